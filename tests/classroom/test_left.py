"""Flocks whose students have left: closed and kept as scenes, and never two of one student."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from dataclasses import replace

import pytest

from app.classroom import classroom
from app.classroom.classroom import Classroom
from app.classroom.student import Role
from app.viewer.gallery.saved_scene import SavedScene
from tests.classroom.running import BUSY, SCENE
from worlds.input_error import InputError

WAITS = 2.0


async def until(holds: Callable[[], bool]) -> None:
    """Wait until something holds."""
    end = time.monotonic() + BUSY
    while not holds():
        assert time.monotonic() < end
        await asyncio.sleep(0.05)


@pytest.fixture
def begun(tmp_path, monkeypatch):
    """A class of which flocks are closed soon, each student with a flock of their own."""
    monkeypatch.setattr(classroom, "WAITS", WAITS)
    monkeypatch.setattr(classroom, "LOOK", 0.2)
    made = Classroom(SavedScene.from_toml(SCENE, "here"), 4, 2, tmp_path)
    made.first_role = Role.OWN

    def run(scenario) -> None:
        async def whole() -> None:
            await made.open()
            try:
                await scenario(made)
            finally:
                await made.close()

        asyncio.run(whole())

    return run


def held(made: Classroom) -> list[int]:
    """How many flocks each process has."""
    return sorted(one.held for one in made.flocks.workers)


def test_a_flock_that_is_left_is_kept_as_it_ran_and_begins_again_from_that(begun):
    async def scenario(made: Classroom) -> None:
        ada, _ = made.admit(made.code, "Ada")
        made.connect(ada)
        place = await made.place_of(ada)
        changed = replace(made.scene, spec=made.scene.spec.but(parameters={"eta": 1.25}))
        await made.flocks.tell_own(ada, "open", changed.to_toml())
        await until(lambda: "eta = 1.25" in ada.scene)
        await asyncio.sleep(WAITS + 1.0)
        assert ada.place is place
        made.disconnect(ada)
        await until(lambda: ada.place is None)
        assert held(made) == [0, 0]
        assert await made.place_of(ada) != place
        assert "eta = 1.25" in await made.flocks.tell_own(ada, "scene")

    begun(scenario)


def test_a_page_that_goes_while_its_flock_opens_leaves_no_second_one(begun):
    async def scenario(made: Classroom) -> None:
        ada, _ = made.admit(made.code, "Ada")
        for _ in range(3):
            gone = asyncio.create_task(made.place_of(ada))
            await asyncio.sleep(0.01)
            gone.cancel()
        place = await made.place_of(ada)
        assert await made.place_of(ada) == place
        assert held(made) == [0, 1]

    begun(scenario)


def test_who_is_taken_out_while_their_flock_opens_has_none(begun):
    async def scenario(made: Classroom) -> None:
        bo, _ = made.admit(made.code, "Bo")
        opening = asyncio.create_task(made.place_of(bo))
        await until(lambda: bo.worker is not None)
        made.forget(bo)
        with pytest.raises(InputError, match="has been closed"):
            await opening
        assert held(made) == [0, 0]

    begun(scenario)
