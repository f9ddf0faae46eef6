"""What one takes along of a run: its recording as tables, pictures and films."""
