"""A small experiment for tests: two models, few agents, soon done."""

from app.studies.experiment_reader import read_file

TEXT = """
title = "Small"
source = "these tests"
picture = "models"
runs = 4

[settings]
world = "wrap"
desired = 0.9984
hold = 5
limit = 400

[settings.parameters]
eta = 0.0

[sizes]
12 = 1.7
20 = 2.2

[[rows]]
model = "vem"
agents = 12
published.k_con.mean = 5.0
published.k_con.quartiles = [4.0, 5.0, 6.0]

[[rows]]
model = "hwvem"
agents = 20
parameters = { p2 = 7.0 }
published.k_con.mean = 5.0
published.k_con.expected = { verdict = "differs", why = "because" }
"""


def small(folder, text=TEXT):
    """The small experiment, read from a file."""
    path = folder / "small.toml"
    path.write_text(text)
    return read_file(path)
