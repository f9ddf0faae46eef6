"""How soon an emergency stop is in the control loop, in quiet and while three browsers flood.

The page of the example laboratory with slow emulated cars, armed; a program of its own presses.
Time is that from pressing to the tick of the loop that stops the cars, by the machine's clock.

With `--cars`: until emulated cars stand, and how far they come meanwhile, whatever fails.

uv run python benchmarks/pages/stop.py [--quick | --cars]
"""

from __future__ import annotations

import os
import signal
import statistics
import subprocess
import sys
import threading
import time
from contextlib import ExitStack
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from app.live.control.arm import OperatorRequest  # noqa: E402
from app.live.laboratory.lab_file import EXAMPLE_FILE, lab_from_toml  # noqa: E402
from app.live.operating.lab_choices import Choices  # noqa: E402
from app.viewer.live.page import LivePage  # noqa: E402

REPEATS, QUICK = 20, 3
FLOODERS = (
    ("--slider", "Scale β", "--camera"),
    ("--key", "Colour by the next quantity"),
    ("--key", "EMERGENCY STOP: this key too"),
)
"""What each of them says as fast as it can; the last one presses the stop's own key."""
BEGINS, SETTLE = 900.0, 60.0
PRESS = """
import sys, time
from http.client import HTTPConnection
sys.path.insert(0, {root!r})
from tests.live.stand_in import StandIn
port = {port}
browser = StandIn(port) if {by_message} else None
while browser is not None and not browser.found("EMERGENCY STOP"):
    time.sleep(0.02)
print("ready", flush=True)
for _ in sys.stdin:
    began = time.monotonic()
    if browser is not None:
        uuid = browser.found("EMERGENCY STOP")
        browser.say(type="GuiUpdateMessage", uuid=uuid, updates={{"value": True}})
    else:
        line = HTTPConnection("localhost", port, timeout=30)
        line.request("POST", "/emergency", headers={{"X-Flockscope": "stop"}})
        assert line.getresponse().status == 204
    print(began, flush=True)
"""


def patient_lab() -> str:
    """The example with slow cars that stay armed: no fence is near, and a busy machine may lag."""
    text = EXAMPLE_FILE.read_text().replace("speed = 1.0", "speed = 0.5")
    for side in ("[-3.05, -3.355]", "[3.05, 3.355]"):
        text = text.replace(side, side.replace("3.05", "60.0").replace("3.355", "60.0"))
    limits = "[limits]\nstale = 0.25\nlong_gap = 10.0\nfrozen = 1.2\nunattended = 30.0\n"
    return f"{text.replace('fence = 0.5', 'fence = 0.7')}\n{limits}"


def program(stack: ExitStack, *arguments: str) -> subprocess.Popen[str]:
    """A program that runs until the end."""
    process = subprocess.Popen(
        [sys.executable, *arguments],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    stack.callback(process.wait)
    stack.callback(process.kill)
    return process


def wait_until(happens, within: float) -> None:
    """Wait until something happens."""
    ends = time.monotonic() + within
    while not happens():
        if time.monotonic() > ends:
            raise TimeoutError("it did not come about")
        time.sleep(0.005)


def arm(page: LivePage) -> None:
    """Arm, from whatever state; cars that are held are armed again."""

    def armed() -> bool:
        status = page.session.status
        if status.arm == "emergency":
            page.session.ask("reset", "benchmark")
        elif status.arm == "safe" and not status.reasons:
            page.session.ask("arm", "benchmark")
        time.sleep(0.05)
        return page.session.status.arm == "armed"

    wait_until(armed, SETTLE)


def press(page: LivePage, presser: subprocess.Popen[str]) -> float:
    """Seconds from pressing to the loop's stop."""
    arm(page)
    time.sleep(0.3)
    if page.session.status.arm != "armed":
        return press(page, presser)
    event_count = len(page.session.events)
    print("press", file=presser.stdin, flush=True)
    began = float(presser.stdout.readline())

    def stopped():
        return [event for event in page.session.events[event_count:] if event.kind == "emergency"]

    wait_until(stopped, SETTLE)
    return stopped()[0].time - began


def measure_stops(page: LivePage, repeats: int, by_message: bool, flooded: bool) -> list[float]:
    """The times of so many stops."""
    port = page.server.get_port()
    with ExitStack() as stack:
        text = PRESS.format(root=str(ROOT), port=port, by_message=by_message)
        presser = program(stack, "-c", text)
        assert presser.stdout.readline() == "ready\n"
        floods = []
        for kinds in FLOODERS[: 3 if flooded else 0]:
            seconds = str(30.0 + 3.0 * repeats)
            command = ("-m", "tests.attacks.flooder", str(port), seconds, "--wait", *kinds)
            floods.append(program(stack, *command))
        for flood in floods:
            assert flood.stdout.readline() == "floods\n"
        for flood in floods:  # all are in: who floods first would keep the others waiting
            print("go", file=flood.stdin, flush=True)
        return [press(page, presser) for _ in range(repeats)]


def overload(stack: ExitStack) -> None:
    """Four programs that do nothing but compute."""
    for _ in range(4):
        program(stack, "-c", "while True: pass")


def send_strangers(stack: ExitStack, server, datagram) -> None:
    """The stream stops, and somebody sends what `datagram(k)` gives every 50 ms."""
    server.stop()
    over = threading.Event()

    def sends() -> None:
        k = 0
        while not over.wait(0.05):
            server.intrude(datagram(k))
            k += 1

    threading.Thread(target=sends, daemon=True).start()
    stack.callback(server.go)
    stack.callback(over.set)


def flip(stack: ExitStack, server) -> None:
    """Every yaw is turned by 180 degrees; y is up."""
    where = server.where

    def turned(seconds: float):
        return {
            name: body._replace(quaternion=(-body.quaternion[2], body.quaternion[3],
                                            body.quaternion[0], -body.quaternion[1]))
            for name, body in where(seconds).items()
        }  # fmt: skip

    server.where = turned
    stack.callback(setattr, server, "where", where)


def signal_loop(stack: ExitStack, room, number: int) -> None:
    """The loop is killed, or stopped for a while."""
    loop = room.operator.process.pid
    os.kill(loop, number)
    if number == signal.SIGSTOP:
        stack.callback(os.kill, loop, signal.SIGCONT)


CASES = {
    "emergency stop": lambda _, room: room.operator.ask(OperatorRequest("emergency", "b")),
    "the stream stops": lambda stack, room: (stack.callback(room.server.go), room.server.stop()),
    "the stream freezes, with noise": lambda stack, room: (
        stack.callback(room.server.thaw),
        room.server.freeze(0.0005),
    ),
    "a stranger's empty datagrams": lambda stack, room: send_strangers(
        stack, room.server, lambda _: b""
    ),
    "old frames are sent again": lambda stack, room: send_strangers(
        stack, room.server, lambda k, old=list(room.server.sent)[-20:]: old[k % len(old)]
    ),
    "every yaw flips": lambda stack, room: flip(stack, room.server),
    "stream stops, machine overloaded": lambda stack, room: (
        overload(stack),
        stack.callback(room.server.go),
        room.server.stop(),
    ),
    "the loop is stopped (SIGSTOP)": lambda stack, room: signal_loop(stack, room, signal.SIGSTOP),
    "the loop is killed (kill -9)": lambda stack, room: signal_loop(stack, room, signal.SIGKILL),
}
"""What fails; the last one ends the room."""


def measure_cars() -> None:
    """Print how soon and how far the cars of a whole room stop: slow ones, then fast ones."""
    from live.full_room import FullRoom

    print(f"{'':34}{'m/s':>6}{'stand after, s':>16}{'run on, m':>12}", flush=True)
    for speed in (0.16, 1.0):
        with FullRoom("red", "blue", speed=speed) as room:
            for case, fails in CASES.items():
                room.run()
                with ExitStack() as stack:
                    fails(stack, room)
                    seconds, metres = room.stops()
                    print(f"{case:34}{speed:6.2f}{seconds:16.2f}{metres:12.3f}", flush=True)
                if case == "emergency stop":
                    room.operator.ask(OperatorRequest("reset", "benchmark"))


def main(quick: bool) -> None:
    """Measure and print."""
    repeats = QUICK if quick else REPEATS
    lab = lab_from_toml(patient_lab(), "the benchmark")
    page = LivePage(Choices.of(lab).choosing(source="emulated cars"), port=0)
    try:
        wait_until(
            lambda: page.session.status is not None and page.session.state.phase == "open", BEGINS
        )
        wait_until(lambda: not page.session.status.reasons, BEGINS)
        of = f"   of {repeats} stops"
        print(f"{'':24}{'':12}{'median, s':>12}{'worst, s':>12}{of}", flush=True)
        for way, by_message in (("own way", False), ("as viser's message", True)):
            for state, flooded in (("in quiet", False), ("flooded", True)):
                took = measure_stops(page, repeats, by_message, flooded)
                print(
                    f"{way:24}{state:12}{statistics.median(took):12.3f}{max(took):12.3f}",
                    flush=True,
                )
    finally:
        page.close()


if __name__ == "__main__":
    if "--cars" in sys.argv[1:]:
        measure_cars()
    else:
        main("--quick" in sys.argv[1:])
