"""What a function gives and what it warns of, for tests of arrays with rows left out."""

import warnings

from agents.observables.array_checks import OmittedRowsWarning


def quietly(function, *arguments):
    """What a function gives, and the OmittedRowsWarning that it warned of; any other warning is an
    error."""
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("error")
        warnings.simplefilter("always", OmittedRowsWarning)
        found = function(*arguments)
    return found, [one.message for one in said]
