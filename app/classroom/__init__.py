"""A class: students with flocks of their own, behind one address."""
