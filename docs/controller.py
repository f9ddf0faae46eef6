"""A controller in a process of its own: each agent turns towards the middle of those it sees.

    uv run python docs/controller.py
    flockscope run vem --kind robot=2,steered=true --steer robot=127.0.0.1:9100 --ticks 300

It hears a datagram of JSON for each tick and answers with one. It ends after some seconds of
silence.
"""

import json
import math
import socket
import sys

PORT = int(sys.argv[1]) if len(sys.argv) > 1 else 9100
SILENCE = 60.0
NEAREST, OF_EACH = 6, 6  # in the plane: place ahead and left, heading, kind, and 1 if there is one
SHARPEST = 0.05  # half turns in a tick


def turn(sees: list[float]) -> float:
    """How far to turn to the left, in half turns."""
    others = [sees[n * OF_EACH : (n + 1) * OF_EACH] for n in range(NEAREST)]
    ahead = sum(other[0] for other in others)
    left = sum(other[1] for other in others)
    wanted = math.atan2(left, ahead) / math.pi if any(other[5] for other in others) else 0.0
    return max(-SHARPEST, min(wanted, SHARPEST))


with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
    line.bind(("127.0.0.1", PORT))
    line.settimeout(SILENCE)
    print(f"waiting on port {line.getsockname()[1]}", flush=True)
    try:
        while True:
            data, sender = line.recvfrom(65535)
            told = json.loads(data)
            actions = {agent["id"]: [turn(agent["sees"])] for agent in told["agents"]}
            answer = {"tick": told["tick"], "actions": actions}
            line.sendto(json.dumps(answer).encode(), sender)
    except TimeoutError:
        print("nobody asks any more")
