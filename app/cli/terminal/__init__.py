"""What reaches the terminal: text, tables, bars, and what was typed wrong."""
