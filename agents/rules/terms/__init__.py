"""What the decisions of several rules are made of: sums over neighbours, fields, escapes."""
