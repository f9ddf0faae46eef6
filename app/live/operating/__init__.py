"""The control loop at work: in a process of its own, with its ends open and a rule that drives."""
