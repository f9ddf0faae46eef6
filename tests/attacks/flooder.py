"""A program that floods a page from a process of its own, and comes back when it is cut off.

python -m tests.attacks.flooder PORT SECONDS [--key LABEL] [--slider LABEL] [--camera] [--stay]
                                            [--wait]

Prints one line of JSON: messages that the line took, connections that came about, connections that
were refused, and the codes with which they were closed.
"""

from __future__ import annotations

import argparse
import contextlib
import json
import sys
import time

from websockets.exceptions import ConnectionClosed, InvalidHandshake

from tests.attacks.raw import said
from tests.live.stand_in import CAMERA, StandIn

AT_ONCE = 50
MOST = 500_000
"""Messages in all."""
MOST_CONNECTIONS = 500


def messages(browser: StandIn, wanted: argparse.Namespace) -> bytes:
    """What is said again and again."""
    made = []
    if wanted.key:
        made.append(said(type="CommandTriggerMessage", uuid=browser.commands[wanted.key]))
    if wanted.slider:
        uuid, one = next(
            (u, c) for u, c in browser.controls.items() if c.get("label") == wanted.slider
        )
        made += [
            said(type="GuiUpdateMessage", uuid=uuid, updates={"value": value})
            for value in (one["min"], one["max"])
        ]
    if wanted.camera:
        made.append(said(**CAMERA))
    return b"".join(made) * AT_ONCE


def known(browser: StandIn, wanted: argparse.Namespace, end: float) -> bool:
    """Whether a browser has been told what it wants to flood."""
    labels = [one.get("label") for one in tuple(browser.controls.values())]
    while time.monotonic() < end and not browser.gone:
        labels = [one.get("label") for one in tuple(browser.controls.values())]
        if (not wanted.key or wanted.key in browser.commands) and (
            not wanted.slider or wanted.slider in labels
        ):
            return True
        time.sleep(0.02)
    return False


def main() -> None:
    """Flood, and print what came of it."""
    parser = argparse.ArgumentParser()
    parser.add_argument("port", type=int)
    parser.add_argument("seconds", type=float)
    parser.add_argument("--key", default="")
    parser.add_argument("--slider", default="")
    parser.add_argument("--camera", action="store_true")
    parser.add_argument("--wait", action="store_true", help="begin when a line is read")
    parser.add_argument("--stay", action="store_true", help="do not come back when cut off")
    wanted = parser.parse_args()
    end = time.monotonic() + wanted.seconds
    sent = connections = refused = 0
    codes: list[int | None] = []
    heap = b""
    said_so = False
    while time.monotonic() < end and sent < MOST and connections + refused < MOST_CONNECTIONS:
        try:
            browser = StandIn(wanted.port)
        except (OSError, InvalidHandshake, TimeoutError, ConnectionClosed):
            refused += 1
            time.sleep(0.02)
            continue
        connections += 1
        with contextlib.suppress(OSError, ConnectionClosed):
            if not heap:
                if not known(browser, wanted, end):
                    continue
                heap = messages(browser, wanted)
            if not said_so:
                print("floods", flush=True)
                said_so = True
                if wanted.wait:
                    sys.stdin.readline()
            each = len(heap) // AT_ONCE and heap.count(heap[: len(heap) // AT_ONCE])
            while time.monotonic() < end and sent < MOST and not browser.gone:
                browser.socket.socket.sendall(heap)
                sent += each
        with contextlib.suppress(Exception):
            codes.append(browser.socket.protocol.close_code if browser.gone else None)
            browser.socket.socket.close()
        if wanted.stay:
            break
    counted = {str(code): codes.count(code) for code in set(codes)}
    print(
        json.dumps(
            {"messages": sent, "connections": connections, "refused": refused, "codes": counted}
        ),
        flush=True,
    )


if __name__ == "__main__":
    main()
