"""What a sweep's file says: its tables, designs, conditions, and where each key is from."""
