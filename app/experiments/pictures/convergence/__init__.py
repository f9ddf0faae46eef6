"""Pictures of convergence times."""
