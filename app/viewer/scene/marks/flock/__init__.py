"""The agents, and what is drawn beside each of them."""
