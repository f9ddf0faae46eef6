"""Pictures of a sweep: lines with bands, maps, points, distributions; what is missing is marked."""
