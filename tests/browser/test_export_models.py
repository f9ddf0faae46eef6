"""Every model as the program of a page: it flies as here, or is refused in a line."""

from __future__ import annotations

import base64
from pathlib import Path

import numpy as np
import pytest

from agents.catalogue import MODELS
from agents.flock import Flock
from agents.web_program import web_program
from worlds.input_error import InputError

KERNEL = Path(__file__).parents[2] / "static" / "export" / "kernel.js"
REFUSED: dict[str, str] = {}
"""Models that no page can run, and what stands in the reason."""
TICKS, AFTER = 20, 5
"""Ticks before sliders are moved, and after. In so few also what is chaotic stays together: in 100
`echelon` and `safe` do not, neither here nor there, and in 10 of `active-brownian` with all sliders
moved, where agents push each other hard, a difference grows 100 000 times.
"""
SHARE = 0.1
"""How far towards its end a slider is moved."""
FLY = """async ({ module, manifest, image, changes, ticks, after }) => {
  const bytes = (text) => Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const kernel = new Kernel(await WebAssembly.compile(bytes(module)), manifest, bytes(image));
  const positions = (count) => { kernel.run(count); return [...kernel.view("flock.position")]; };
  const before = positions(ticks);
  for (const [name, value] of changes)
    kernel.set(manifest.parameters.find((one) => one.name === name), value);
  return [before, positions(after)];
}"""


@pytest.fixture(scope="module")
def page(chromium):
    """A page that has the class Kernel."""
    page = chromium.new_page()
    page.add_script_tag(content=KERNEL.read_text("utf-8"))
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
    monkeypatch.setattr("agents.web_program.web_measures", lambda _: [])
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
    }
    for there, expected in zip(page.evaluate(FLY, request), here, strict=True):
        assert np.reshape(there, expected.shape) == pytest.approx(expected, abs=1e-9)
    assert changes
