"""Drawings that explain a rule: the papers' schemes, made from what the rule itself does."""
