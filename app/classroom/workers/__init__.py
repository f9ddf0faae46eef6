"""Processes that hold laboratories, and what the class asks of them."""
