"""What comes in from browsers: connections, messages and the emergency stop's own way."""
