"""The server: who may talk to it, what it serves and what it takes from browsers."""
