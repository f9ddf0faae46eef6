"""The control loop in a process of its own, its operator, and the driver that is a rule."""
