"""Pictures of flocks on missions."""
