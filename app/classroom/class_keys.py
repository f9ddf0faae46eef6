"""What opens a class: a code for students on the wall, a key for the teacher, cookies for both.

A code is short enough to be typed; a cookie is what a page has after that. Of cookies only hashes
are kept, and all are compared in constant time.
"""

from __future__ import annotations

import hashlib
import hmac
import secrets

LETTERS = "23456789abcdefghjkmnpqrstuvwxyz"
"""Of codes: none that looks like another."""
GROUPS, OF = 2, 5
"""A code is so many groups of so many letters: 31 to the power of 10, 8e14, of them."""
LONGEST = 64
"""Letters of whatever somebody gives as a code, a key or a cookie."""


def new_code() -> str:
    """A code for a class.

    >>> code = new_code()
    >>> len(code), code[5]
    (11, '-')
    """
    made = ("".join(secrets.choice(LETTERS) for _ in range(OF)) for _ in range(GROUPS))
    return "-".join(made)


def normalise_code(code: str) -> str:
    """A code as somebody may have typed it.

    >>> normalise_code(" K7M2P 9XQ4T ")
    'k7m2p-9xq4t'
    """
    letters = "".join(one for one in code[: 2 * LONGEST].lower() if one.isalnum())
    return "-".join(letters[at : at + OF] for at in range(0, len(letters), OF))


def new_key() -> str:
    """A key for the teacher, or a cookie."""
    return secrets.token_urlsafe(24)


def hash_key(key: str) -> str:
    """What is kept of a cookie."""
    return hashlib.sha256(key.encode("utf-8", "surrogatepass")).hexdigest()


def is_same_text(one: str, other: str) -> bool:
    """Whether two are the same, in a time that tells nothing."""
    return hmac.compare_digest(one.encode("utf-8", "surrogatepass"), other.encode())
