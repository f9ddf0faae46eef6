"""What answers a browser that asks by HTTP: who may ask, for what, and with which headers."""
