"""What is drawn of the inspected agent."""
