"""Which parameter matters: indices of a sweep over Saltelli's or Morris' design, told in words."""
