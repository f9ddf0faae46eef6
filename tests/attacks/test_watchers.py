"""Those who only watch, and send all that a browser can send: nothing comes of it for others."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import pytest

from app.front.message_filter import KINDS, KNOWN
from app.viewer.lab.laboratory import Laboratory
from app.viewer.run.run_preset import preset_spec
from app.viewer.watching.watch_page import HEARD, WatchPage
from tests.attacks.raw import Raw, said
from tests.live.stand_in import StandIn
from tests.viewer.waiting import until

AT_ONCE = 30
"""Messages of one connection: so few that its limits let them through."""
LATE = 60.0
PLACE = {"position": [1.0, 2.0, 0.0], "wxyz": [1.0, 0.0, 0.0, 0.0]}
RAY = {"ray_origin": [0.0, 0.0, 30.0], "ray_direction": [0.0, 0.0, -1.0], "modifier": None}
UPLOAD = {
    "transfer_uuid": "mine",
    "filename": "mine.toml",
    "mime_type": "",
    "part_count": 1,
    "size_bytes": 3,
}
VALUES = (True, 3.0, "side", "nothing")


@pytest.fixture(scope="module")
def laboratory():
    made = Laboratory(preset_spec("hwvem", agents=30, seed=2), port=0, running=False)
    assert made.simulation.ready.wait(180)
    until(lambda: made.parameters.controls)
    made.scene.show_leader_gizmo(True)
    yield made
    made.close()


@pytest.fixture(scope="module")
def page(laboratory):
    made = WatchPage(laboratory, "Ada")
    yield made
    made.close()


class Witness(StandIn):
    """A browser that keeps all it is told."""

    def __init__(self, port: int):
        self.heard: list[dict[str, Any]] = []
        super().__init__(port)

    def hear(self, message: dict[str, Any]) -> None:
        self.heard.append(message)
        super().hear(message)


def settled(browser: Witness) -> None:
    """Wait until a browser is told nothing new."""
    before = -1
    while len(browser.heard) != before:
        before = len(browser.heard)
        time.sleep(2.5)


def everything(teacher: Witness, witness: Witness) -> list[bytes]:
    """Messages of every kind, to all that there is on the laboratory's page and the other's."""
    controls = [*teacher.controls, *witness.controls]
    commands = [*teacher.commands.values(), *witness.commands.values()]
    nodes = sorted({*teacher.nodes, *witness.nodes, "/leader_gizmo", "/handles/obstacle"})
    made = [
        said(type="GuiUpdateMessage", uuid=uuid, updates={"value": value})
        for uuid in controls
        for value in VALUES
    ]
    made += [said(type="GuiUpdateMessage", uuid=uuid, updates={"label": "x"}) for uuid in controls]
    made += [said(type="GuiButtonHoldMessage", uuid=uuid, frequency=10.0) for uuid in controls]
    made += [said(type="CommandTriggerMessage", uuid=uuid) for uuid in commands]
    for name in nodes:
        made += [
            said(type="TransformControlsDragStartMessage", name=name),
            said(type="TransformControlsUpdateMessage", name=name, **PLACE),
            said(type="TransformControlsDragEndMessage", name=name),
            said(
                type="SceneNodeClickMessage",
                name=name,
                instance_index=1,
                screen_pos=[0.5, 0.5],
                **RAY,
            ),
        ]
    made += [
        said(type="FileTransferStartUpload", source_component_uuid=uuid, **UPLOAD)
        for uuid in controls
    ]
    made += [said(type=kind) for kind in sorted(KNOWN - set(HEARD))]
    made += [
        said(type="FileTransferPart", source_component_uuid=controls[0], transfer_uuid="mine",
             part_index=0, content=b"abc"),
        said(type="ScenePointerMessage", event_type="rect-select", ray_origin=None,
             ray_direction=None, screen_pos=[[0.1, 0.1], [0.9, 0.9]], modifier=None),
        said(type="ScenePointerMessage", event_type="click", screen_pos=[[0.5, 0.5]], **RAY),
    ]  # fmt: skip
    return made


def test_whatever_a_watcher_sends_changes_neither_the_run_nor_what_others_see(
    page, laboratory, count
):
    simulation = laboratory.simulation
    with Witness(laboratory.port) as teacher, Witness(page.port) as witness:
        until(lambda: len(page.watchers) == 1 and laboratory.browsers() == 1)
        settled(witness)
        settled(teacher)
        messages = everything(teacher, witness)
        inputs = laboratory.server.gui._gui_input_handle_from_uuid
        before = (
            simulation.state,
            simulation.wanted.first,
            simulation.frame.position.copy(),
            {uuid: one.value for uuid, one in inputs.items()},
        )
        witness.heard.clear()
        teacher.heard.clear()
        connections = 0
        for first in range(0, len(messages), AT_ONCE):
            with Raw(page.port) as attacker:
                connections += 1
                for message in messages[first : first + AT_ONCE]:
                    attacker.say(message)
                attacker.line.ping().wait(LATE)  # by then all before it has been read
                assert not attacker.closed
        until(lambda: len(page.watchers) == 1, LATE)
        settled(witness)
        settled(teacher)
        assert simulation.state == before[0]
        assert simulation.wanted.first == before[1]
        assert np.array_equal(simulation.frame.position, before[2])
        assert {uuid: one.value for uuid, one in inputs.items()} == before[3]
        assert witness.heard == []
        assert teacher.heard == []
        assert not page.server.gui._current_file_upload_states
        assert laboratory.selected is None
    count(messages=len(messages), connections=connections)


def test_a_watcher_who_floods_is_cut_off_and_the_others_go_on(page, laboratory, count):
    click = said(type="ScenePointerMessage", event_type="click", screen_pos=[[0.5, 0.5]], **RAY)
    with StandIn(page.port) as witness:
        until(lambda: len(page.watchers) == 1)
        with Raw(page.port) as attacker:
            sent = attacker.pour(click, 10.0, most=20_000)
            until(lambda: attacker.closed, LATE)
        until(lambda: len(page.watchers) == 1, LATE)
        before = laboratory.simulation.frame.tick
        laboratory.simulation.step()
        card = f"<span>tick</span><b>{before + 1}</b>"
        until(lambda: any(card in str(one.get("content")) for one in witness.controls.values()))
        assert not witness.gone
    count(messages=sent, connections=1)


def test_it_hears_of_no_kind_that_the_laboratory_does_not():
    assert set(HEARD) < set(KINDS)
    assert all(HEARD[kind].rate <= KINDS[kind].rate for kind in HEARD)
    assert not any("Transfer" in kind or "Transform" in kind or "Node" in kind for kind in HEARD)
