"""A whole room as in `full_room`, driven from a page in a process of its own, by `live lab`."""

from __future__ import annotations

import re
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from cli.calling import PROGRAM

from live.full_room import FullRoom
from live.stand_in import StandIn

BEGINS = 240.0
"""Seconds until the page can be asked to arm: a rule is compiled, by a machine that may be busy."""
AGAIN = 0.5
"""Seconds between two attempts to arm."""


class ServedRoom(FullRoom):
    """Used with `with`; `process` is the page's, `browser` the one that arms."""

    def operate(self, lab):
        """Serve the page, and open a browser."""
        self.folder = tempfile.TemporaryDirectory()
        file = Path(self.folder.name) / "lab.toml"
        file.write_text(lab.to_toml(), encoding="utf-8")
        asked = ["live", "lab", str(file), "--port", "0", "--no-open"]
        self.said = Path(self.folder.name) / "stderr.txt"
        with self.said.open("w") as said:
            self.process = subprocess.Popen(
                [*PROGRAM, *asked],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=said,
                text=True,
            )
        self.operator = self
        self.port = self.told_port()
        self.browser = StandIn(self.port)

    def told_port(self):
        """The port, as the program prints it."""
        assert self.process.stdout is not None
        for line in self.process.stdout:
            if found := re.search(r"localhost:(\d+)", line):
                return int(found[1])
        raise AssertionError("the page did not begin")

    def told_code(self):
        """The code without which no browser arms, as the program prints it; empty before that."""
        found = re.search(r"code (\d{6})", self.said.read_text(encoding="utf-8"))
        return found[1] if found else ""

    def close(self):
        """End the page's process, whatever state it is in."""
        self.browser.socket.close()
        for number in (signal.SIGCONT, signal.SIGTERM):
            self.process.send_signal(number)
        self.process.wait(60.0)
        self.process.stdout.close()
        self.folder.cleanup()

    @property
    def events(self):
        """None are known here."""
        return []

    def run(self):
        """Arm in the browser, again if need be, until all cars drive."""
        asked = 0.0

        def drives():
            nonlocal asked
            browser = self.browser
            if time.monotonic() - asked > AGAIN:
                asked = time.monotonic()
                label = "Arm" if browser.found("Arm") else "Arm …"
                if label == "Arm" and browser.can(label):
                    browser.set("Code", self.told_code())
                if browser.can(label):
                    browser.set(label, True)
            return min(abs(car.speed) for car in self.plant.cars.values()) > 0.5

        self.until(drives, BEGINS)


def descendants(pid):
    """The processes that a process has begun, those that they have begun, and so on."""
    children = []
    for task in Path(f"/proc/{pid}/task").iterdir():
        children += [int(one) for one in (task / "children").read_text().split()]
    return children + [one for child in children for one in descendants(child)]


def is_there(pid):
    """Whether a process runs."""
    try:
        stat = Path(f"/proc/{pid}/stat").read_text()
    except OSError:
        return False
    return stat.rpartition(")")[2].split()[0] != "Z"
