"""What charts of runs consist of: lines with intervals, maps, distributions, scaling, colours."""
