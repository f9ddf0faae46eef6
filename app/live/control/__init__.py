"""The control loop and what keeps it safe: no device, no file, no process."""
