"""The card of the agent that was clicked."""
