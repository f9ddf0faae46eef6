"""What browsers drag goes through only if it is a pose; else the handle stays as it is."""

from __future__ import annotations

import math

import numpy as np
import pytest

from app.front.server import admit_browsers, close_server, open_server
from tests.viewer.test_server import join, say
from tests.viewer.waiting import until

STRAIGHT = [1.0, 0.0, 0.0, 0.0]


@pytest.fixture(scope="module")
def server():
    opened = open_server(port=0)
    admit_browsers(opened)
    yield opened
    close_server(opened)


@pytest.fixture
def handle(server):
    made = server.scene.add_transform_controls("/handle", position=(0.5, 0.5, 0.5))
    yield made
    made.remove()


def drag(client, position, wxyz=STRAIGHT) -> None:
    say(
        client,
        type="TransformControlsUpdateMessage",
        name="/handle",
        owner="",
        position=position,
        wxyz=wxyz,
    )


@pytest.mark.filterwarnings("ignore:.*does not match annotation")
@pytest.mark.parametrize(
    ("position", "wxyz"),
    [
        ([1.0, 2.0], STRAIGHT),
        ([], STRAIGHT),
        ([[1.0], [2.0, 3.0]], STRAIGHT),
        ([1.0, 2.0, 3.0, 4.0], STRAIGHT),
        ({"x": 1.0}, STRAIGHT),
        ("ab", STRAIGHT),
        ([math.nan, 2.0, 3.0], STRAIGHT),
        ([math.inf, 2.0, 3.0], STRAIGHT),
        ([1.0, 2.0, 3.0], [0.0, 0.0, 0.0, 0.0]),
        ([1.0, 2.0, 3.0], [math.nan, 0.0, 0.0, 0.0]),
        ([1.0, 2.0, 3.0], [1.0, 0.0]),
    ],
)
def test_what_is_no_pose_leaves_the_handle_where_it_is(server, handle, position, wxyz):
    heard = []

    @handle.on_update
    async def _(event):
        heard.append(event.target.position.tolist())

    with join(server) as client:
        drag(client, position, wxyz)
        drag(client, [7.0, 8.0, 9.0])
        until(lambda: heard)
    assert heard == [[7.0, 8.0, 9.0]]
    assert handle.wxyz.tolist() == STRAIGHT
    handle.position = (0.0, 0.0, 1.0)
    assert np.array_equal(handle.position, [0.0, 0.0, 1.0])
