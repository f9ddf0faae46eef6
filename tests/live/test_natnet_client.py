"""The emulated NatNet server read by another client, which knows nothing of `motioncapture`."""

import math
import time

import pytest

from app.live.sources.axes import Axes
from app.live.sources.feed import Feed
from app.live.sources.mocap import MotionCapture
from tests.live.natnet_emulator import Body, NatNetEmulator

pytest.importorskip("motioncapture")
natnet = pytest.importorskip("natnet")

WITHIN = 20.0
Y_UP = Axes(up="y")


def standing(_seconds):
    """Three cars at rest, y up; the last is not tracked."""
    return {
        "red": Body((1.0, 0.05, -2.0), (0.0, 0.0, 0.0, 1.0)),
        "blue": Body((-0.5, 0.05, 0.25), (0.0, math.sin(0.6), 0.0, math.cos(0.6))),
        "grey": Body((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0), tracked=False),
    }


def heard_by_natnet(server):
    """The names by number and the newest frame, as the package `natnet` reads them."""
    client = natnet.NatNetClient(
        "127.0.0.1",
        "127.0.0.1",
        command_port=server.command_port,
        data_port=server.data_port,
        use_multicast=True,
    )
    frames, models = [], []
    client.on_data_frame_received_event.handlers.append(frames.append)
    client.on_data_description_received_event.handlers.append(models.append)
    ends = time.monotonic() + WITHIN
    with client:
        client.request_modeldef()
        while not (frames and models):
            assert time.monotonic() < ends, "this did not come about"
            client.update_sync()
            time.sleep(0.01)
    return {body.id_num: body.name for body in models[-1].rigid_bodies}, frames[-1]


@pytest.mark.parametrize("version", [(3, 1), (4, 0)])
def test_both_clients_read_the_same_poses(version):
    with (
        NatNetEmulator(standing, version=version, multicast=True) as server,
        Feed(MotionCapture("optitrack", "127.0.0.1", Y_UP, server.options)) as feed,
    ):
        ours = feed.first(WITHIN)
        names, theirs = heard_by_natnet(server)
    bodies = {names[body.id_num]: body for body in theirs.rigid_bodies}
    assert {name for name, body in bodies.items() if body.tracking_valid} == {"red", "blue"}
    assert {sighting.name for sighting in ours.sightings if sighting.valid} == {"red", "blue"}
    for name in ("red", "blue"):
        assert ours.pose(name) == Y_UP.pose(bodies[name].pos, bodies[name].rot)
        assert bodies[name].pos == pytest.approx(standing(0.0)[name].point)


def test_the_frames_are_numbered_and_timed_as_the_server_sends_them():
    with NatNetEmulator(standing, rate=100.0, multicast=True) as server:
        _, frame = heard_by_natnet(server)
    assert frame.suffix.timestamp == pytest.approx(frame.prefix.frame_number / 100.0)
