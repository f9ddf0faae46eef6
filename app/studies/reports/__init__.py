"""The outcome of an experiment for people: tables, JSON, a CSV file."""
