"""A class that runs as a command, and people who come to it without a browser."""

from __future__ import annotations

import http.client
import json
import re
import signal
import subprocess
import sys
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from urllib.parse import urlencode

import msgspec
import viser
from websockets.sync.client import ClientConnection, connect

from tests.live.stand_in import CAMERA
from tests.viewer.waiting import until

PROTOCOL = f"viser-v{viser.__version__}"
SCENE = """
title = "Thirty agents"
[run]
model = "vem"
agents = 30
seed = 1
size = 5.0
[run.parameters]
eta = 0.5
"""
BUSY = 60.0
"""Seconds for what a busy machine takes its time to do."""


COMPILES = 600.0
"""Seconds for the page of students to be compiled there: ten of an idle core."""


@dataclass
class Answer:
    """What came back."""

    status: int
    headers: http.client.HTTPMessage
    text: str


@dataclass
class Person:
    """Somebody at the door of a class, with the cookies that they have."""

    port: int
    cookies: dict[str, str] = field(default_factory=dict)
    number: int = 0

    @property
    def base(self) -> str:
        """The origin of the class's pages."""
        return f"http://localhost:{self.port}"

    def ask(
        self,
        path: str,
        method: str = "GET",
        body: str | None = None,
        headers: dict[str, str] | None = None,
    ) -> Answer:
        """One request; cookies that are set are kept."""
        line = http.client.HTTPConnection("localhost", self.port, timeout=BUSY)
        given = {"Cookie": self.cookie} if self.cookies else {}
        try:
            line.request(method, path, body, given | (headers or {}))
            got = line.getresponse()
            text = got.read().decode("utf-8", "replace")
        finally:
            line.close()
        for one in got.headers.get_all("Set-Cookie", []):
            name, _, value = one.partition(";")[0].partition("=")
            self.cookies[name] = value
        return Answer(got.status, got.headers, text)

    @property
    def cookie(self) -> str:
        """The header with the cookies."""
        return "; ".join(f"{name}={value}" for name, value in self.cookies.items())

    def send(self, path: str, values: object) -> Answer:
        """What a script of our own page sends."""
        headers = {"X-Flockscope": "class", "Origin": self.base, "Sec-Fetch-Site": "same-origin"}
        return self.ask(path, "POST", json.dumps(values), headers)

    def do(self, what: str, **values: object) -> Answer:
        """What the teacher's page asks for."""
        return self.send("/class/do", {"do": what, **values})

    def form(self, path: str, **values: str) -> Answer:
        """What a form of our own page sends."""
        headers = {"Content-Type": "application/x-www-form-urlencoded", "Origin": self.base}
        return self.ask(path, "POST", urlencode(values), headers)

    def told(self, path: str, most: float = BUSY) -> dict:
        """The first event of a stream."""
        line = http.client.HTTPConnection("localhost", self.port, timeout=most)
        try:
            line.request("GET", path, headers={"Cookie": self.cookie})
            got = line.getresponse()
            assert got.status == 200, got.status
            first = got.readline().decode()
        finally:
            line.close()
        return json.loads(first.removeprefix("data: "))

    @contextmanager
    def listening(self, path: str):
        """A stream that is open."""
        line = http.client.HTTPConnection("localhost", self.port, timeout=BUSY)
        line.request("GET", path, headers={"Cookie": self.cookie})
        got = line.getresponse()
        assert got.status == 200, got.status
        try:
            yield got
        finally:
            got.close()
            line.close()

    def connect(self, path: str = "/", **headers: str) -> ClientConnection:
        """A websocket, as viser's page opens it, introduced."""
        line = connect(
            f"ws://localhost:{self.port}{path}",
            subprotocols=[PROTOCOL],  # type: ignore[list-item]
            additional_headers={"Cookie": self.cookie, **headers},
            max_size=None,
            open_timeout=BUSY,
            close_timeout=0.2,
            ping_interval=None,
        )
        line.send(msgspec.msgpack.encode(CAMERA))
        return line


@dataclass
class Running:
    """A class that runs."""

    process: subprocess.Popen[str]
    link: str
    teachers_link: str
    said: list[str]

    @property
    def port(self) -> int:
        """Where it is."""
        return int(re.search(r":(\d+)/", self.teachers_link)[1])

    @property
    def code(self) -> str:
        """What stands on the wall."""
        return self.link.rpartition("/")[2]

    def stranger(self) -> Person:
        """Somebody who has nothing."""
        return Person(self.port)

    def student(self, name: str, code: str = "") -> Person:
        """Somebody who has entered by the code."""
        person = self.stranger()
        answer = person.form("/join", code=code or self.code, name=name)
        assert answer.status == 303, answer.text
        return person

    def teacher(self) -> Person:
        """The teacher."""
        person = self.stranger()
        answer = person.form("/teach", key=self.teachers_link.rpartition("/")[2])
        assert answer.status == 303, answer.text
        return person

    def stop(self, how: signal.Signals = signal.SIGINT) -> str:
        """Stop it; all that it has said on stderr."""
        self.process.send_signal(how)
        rest, errors = self.process.communicate(timeout=BUSY)
        self.said.append(rest)
        return errors


@contextmanager
def running(folder: Path, *options: str, scene: str | None = None, first: str = ""):
    """A class in a folder, stopped at the end; flocks run on the server where no option says.

    `first` is what its process does before anything else, Python.
    """
    (folder / "scene.toml").write_text(SCENE)
    code = f"{first}\nimport runpy\nrunpy.run_module('flockscope', run_name='__main__')"
    begin = ("-c", code) if first else ("-m", "flockscope")
    command = [sys.executable, "-P", *begin, "class", scene or "scene.toml"]
    port = () if "--port" in options else ("--port", "0")
    flocks = () if "--flocks" in options else ("--flocks", "on-server")
    process = subprocess.Popen(
        [*command, *port, *flocks, "--no-open", *options],
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    try:
        said: list[str] = []
        while len(said) < 2 or "you alone" not in said[-1]:
            line = process.stdout.readline()
            assert line, process.communicate()[1]
            said.append(line)
        link = said[0].split()[-1]
        yield Running(process, link, re.search(r"alone: (\S+)", said[-1])[1], said)
    finally:
        if process.poll() is None:
            process.terminate()
            try:
                process.communicate(timeout=BUSY)
            except subprocess.TimeoutExpired:
                process.kill()
                raise


def roster(teacher: Person) -> dict:
    """What the teacher's page shows."""
    return teacher.told("/class/roster")


def has_compiled(teacher: Person) -> None:
    """Wait until students' page is compiled."""
    until(lambda: not roster(teacher)["flocks"], COMPILES)


def number_of(teacher: Person, name: str) -> int:
    """The number of a student."""
    return next(one["number"] for one in roster(teacher)["students"] if one["name"] == name)


def seen(teacher: Person, name: str):
    """How a student's flock stands, once it has been looked at."""

    def found():
        return next(one["seen"] for one in roster(teacher)["students"] if one["name"] == name)

    return until(found, BUSY)
