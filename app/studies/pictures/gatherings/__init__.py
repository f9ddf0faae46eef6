"""Pictures of flocks in a box: groups, polarisation, crashes."""
