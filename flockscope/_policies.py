"""What `flockscope` promises of policies; a file of one imports no compiler by it."""

from agents.policies import Policy, policy

__all__ = ["Policy", "policy"]
