"""Flapping flight for people: what is asked, tables, pictures."""
