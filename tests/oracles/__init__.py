"""Naive versions of the models, the noise and the observables, written from the papers.

They are plain Python and NumPy, slow, meant to be checked by reading them beside the paper, and
import nothing of the engine. `flocks.py` alone does: it makes the flocks they are compared with.
"""
