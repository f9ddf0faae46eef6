"""The only address of a class that others reach: who may, and to what they are passed on."""
