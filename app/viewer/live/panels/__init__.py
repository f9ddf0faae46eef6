"""The panels of a laboratory of real cars."""
