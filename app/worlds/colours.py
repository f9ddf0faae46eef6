"""Colours and type of a drawn world."""

FLOOR = "#f7f8fa"
SOLID = "#5b6673"
SOLID_EDGE = "#343c46"
INK = "#3c434b"
PALE = "#9aa3ad"
START = "#2a9d5c"
PATH = "#2166ac"
GOAL = "#c0392b"
POINTS = "#e08214"
HEIGHTS = ("#e8e4d4", "#a9c0c4", "#5b86a0", "#27496d")
"""Colours of heights in space, from the floor to the ceiling."""
LOOK = {
    "font.size": 10,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.spines.left": False,
    "axes.spines.bottom": False,
    "axes.labelcolor": INK,
    "figure.titlesize": 11,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "svg.hashsalt": "flockscope",
}
