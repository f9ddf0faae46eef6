"""The runs that are made: how one ended, and the store that keeps them whatever happens."""
