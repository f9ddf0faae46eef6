"""A laboratory of cars as a file: what it may say, and what may be chosen instead."""
