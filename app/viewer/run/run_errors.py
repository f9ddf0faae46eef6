"""Errors in the words of whoever has to read them."""

from __future__ import annotations

from worlds.input_error import InputError


class ComparedFlockError(RuntimeError):
    """What one of two flocks raised, told with the name of its model."""


class StrayAgentError(Exception):
    """An agent is where it cannot be; the flock runs on."""


def in_words(error: BaseException) -> str:
    """An error as one line for the user.

    >>> in_words(IndexError("out of reach")), in_words(InputError("there is no flock"))
    ('IndexError: out of reach', 'there is no flock')
    """
    if isinstance(error, InputError | ArithmeticError | ComparedFlockError | StrayAgentError):
        return str(error)
    return f"{type(error).__name__}: {error}"
