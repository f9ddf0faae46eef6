"""Every model as the program of a page: it flies as here, also from another start."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.web.web_program import web_program
from worlds.input_error import InputError

FOLDER = Path(__file__).parents[2] / "static" / "export"
REFUSED: dict[str, str] = {}
"""Models that no page can run, and what stands in the reason."""
TICKS, AFTER = 20, 5
"""Ticks before sliders are moved, and after. In so few also what is chaotic stays together: in 100
`echelon` and `safe` do not, neither here nor there, and in 10 of `active-brownian` with all sliders
moved, where agents push each other hard, a difference grows 100 000 times.
"""
SHARE = 0.1
"""How far towards its end a slider is moved."""
OTHER_SEED = 11
MORE_AGENTS = 3
FLY = """async ({ module, manifest, image, changes, ticks, after, start }) => {
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const kernel = new Kernel(await WebAssembly.compile(bytes(module)), manifest, bytes(image));
  const positions = (count) => { kernel.run(count); return [...kernel.view("flock.position")]; };
  const before = positions(ticks);
  for (const [name, value] of changes)
    kernel.set(manifest.parameters.find((one) => one.name === name), value);
  const later = positions(after);
  kernel.reset();
  new Starter(kernel).begin(...start);
  const ids = [...kernel.view("flock.ids")].map(Number);
  return [before, later, positions(0), positions(ticks), ids];
}"""


@pytest.fixture(scope="module")
def page(chromium):
    """A page that has the class Kernel."""
    page = chromium.new_page()
    for name in ("kernel.js", "start.js"):
        page.add_script_tag(content=(FOLDER / name).read_text("utf-8"))
    yield page
    page.close()


def move_sliders(flock: Flock, sliders: list[dict]) -> list[tuple[str, float]]:
    """Move all that a page can move and that may be moved; their names and new values."""
    changes = []
    for slider in sliders:
        value = slider["value"] + SHARE * (slider["high"] - slider["value"])
        if slider["slots"] and value != slider["value"]:
            try:
                flock.set(**{slider["name"]: value})
            except InputError:
                continue  # zones would be out of order
            changes.append((slider["name"], value))
    return changes


@pytest.mark.parametrize("model", MODELS)
def test_a_page_flies_every_model_as_here(page, model, monkeypatch):
    # What pages measure is the same code in each, and most of the time that a page takes to make.
    monkeypatch.setattr("agents.web.web_program.web_measures", lambda *_: [])
    if model in REFUSED:
        with pytest.raises(InputError, match=REFUSED[model]) as caught:
            web_program(Flock(model, rng=3))
        assert "\n" not in str(caught.value)
        return
    program = web_program(Flock(model, rng=3))
    flock = Flock(model, rng=3)
    flock.run(TICKS)
    here = [flock.position.copy()]
    changes = move_sliders(flock, program.manifest["parameters"])
    flock.run(AFTER)
    here.append(flock.position)
    request = {
        "module": base64.b64encode(program.module).decode(),
        "manifest": program.manifest,
        "image": base64.b64encode(program.memory).decode(),
        "changes": changes,
        "ticks": TICKS,
        "after": AFTER,
        "start": [str(OTHER_SEED), flock.options.agents + MORE_AGENTS],
    }
    first = Flock(model, rng=3).spec
    # Where obstacles are drawn by the seed, too, a page keeps those that it has.
    changes_of_start = {"agents": first.agents + MORE_AGENTS, "seed": OTHER_SEED}
    anew = Flock(first.but(**changes_of_start, world=flock.world, size=None, layout=None))
    here.append(anew.position.copy())
    anew.run(TICKS)
    here.append(anew.position)
    *places, ids = page.evaluate(FLY, request)
    for there, expected in zip(places, here, strict=True):
        assert np.reshape(there, expected.shape) == pytest.approx(expected, abs=1e-9)
    assert ids == anew.ids.tolist()
    is_of_cars = MODELS[model].body.vehicle is not None
    assert (program.manifest["car"] is not None) == is_of_cars
    assert changes
