"""Students whose flocks run in their browsers, as programs: they load the page and hand in.

`benchmarks/pages/classroom.py --in-browser` measures a class with them.
"""

from __future__ import annotations

import asyncio
import json
import re
import statistics
import tempfile
import time
from functools import partial
from typing import Any

import aiohttp
from classroom import Class, Counted, press_control, teach

AGENTS = 300
COMES = 0.05
"""Seconds between two who come: a whole class is there within half a minute."""
QUESTION = {
    "title": "Order against noise",
    "parameter": "eta",
    "measure": {"observe": "polarisation", "over": 100},
    "ticks": 500,
    "values": [0.1 * k for k in range(11)],
}
MODULE = re.compile(r'data-file="(flock/[0-9a-f]+\.wasm)"')
BUSY = (429, 503)
"""What is asked again a moment later."""


class PageStudent:
    """One whose page is a flock: it comes, listens, hands in, and looks at the class's results."""

    def __init__(self, session: aiohttp.ClientSession, link: str, number: int):
        self.session = session
        self.base, _, self.code = link.rpartition("/")
        self.number = number
        self.headers = {"Origin": self.base}
        self.told: dict[str, Any] = {}
        self.changed = asyncio.Event()
        self.began = self.waited = 0.0
        """Seconds until its flock was there, and until its result was."""
        self.answer = ""
        self.plots = 0

    async def get(self, path: str) -> bytes:
        """What is at an address of the class."""
        while True:
            async with self.session.get(f"{self.base}/{path}", headers=self.headers) as answer:
                content = await answer.read()
                if answer.status not in BUSY:
                    assert answer.status == 200, content
                    return content
            await asyncio.sleep(1.0)

    async def enter(self) -> None:
        """Enter by the code, and load the flock."""
        entered = time.perf_counter()
        values = {"code": self.code, "name": f"Student {self.number}"}
        async with self.session.post(
            f"{self.base}/join", data=values, headers=self.headers, allow_redirects=False
        ) as answer:
            assert answer.status == 303, await answer.text()
            cookies = "; ".join(f"{one.key}={one.value}" for one in answer.cookies.values())
        self.headers |= {"Cookie": cookies}
        await self.load()
        self.began = time.perf_counter() - entered

    async def load(self) -> None:
        """Load the page and what runs in it, which a browser keeps."""
        found = MODULE.search((await self.get("")).decode())
        assert found is not None, "the page has no flock"
        if not self.told:
            await self.get(found[1])

    async def listen(self) -> None:
        """Hear of the class; results are fetched as a page does, and a new flock is loaded."""
        async with self.session.get(f"{self.base}/class/mine", headers=self.headers) as line:
            async for row in line.content:
                if not row.startswith(b"data: "):
                    continue
                told = json.loads(row[6:])
                if self.told and told["flock"] != self.told["flock"]:
                    await self.load()
                self.told = told
                self.changed.set()

    async def look(self) -> None:
        """Fetch the results as they grow."""
        drawn = 0
        while True:
            await self.changed.wait()
            self.changed.clear()
            if self.told["plot"]["version"] != drawn:
                drawn = self.told["plot"]["version"]
                await self.get("class/plot.json")
                self.plots += 1
                await asyncio.sleep(self.told["plot"]["apart"])

    async def hand_in(self, value: float) -> None:
        """Hand in a run with this noise."""
        headers = self.headers | {"X-Flockscope": "class"}
        began, values = time.perf_counter(), {"values": {"eta": value}}
        async with self.session.post(
            f"{self.base}/class/hand-in", json=values, headers=headers
        ) as answer:
            self.answer = await answer.text()
            assert answer.status == 200, self.answer
        self.waited = time.perf_counter() - began


async def measure_in_browsers(count: int, over: float) -> None:
    """Measure a class of so many students who hand in within `over` seconds, and print."""
    with tempfile.TemporaryDirectory() as folder:
        classroom = Class(folder, AGENTS, count, flocks="in-browser")
        try:
            connector = aiohttp.TCPConnector(limit=0)
            connector._factory = partial(Counted, loop=asyncio.get_running_loop())
            options = {
                "timeout": aiohttp.ClientTimeout(total=None),
                "cookie_jar": aiohttp.DummyCookieJar(),
            }
            async with aiohttp.ClientSession(connector=connector, **options) as session:
                await measure_students(session, classroom, count, over)
        finally:
            classroom.end()


async def measure_students(
    session: aiohttp.ClientSession, classroom: Class, count: int, over: float
) -> None:
    """Measure a class that runs, and print."""
    cookie = await teach(session, classroom.teachers)
    began = time.perf_counter()
    while (await roster(session, classroom, cookie))["flocks"]:
        await asyncio.sleep(0.2)
    print(f"{count} students, flocks of {AGENTS} agents in their browsers")
    print(f"  compiled after            {time.perf_counter() - began:8.1f} s")
    students = [PageStudent(session, classroom.link, number) for number in range(count)]
    teacher = asyncio.create_task(listen_to_roster(session, classroom, cookie))
    part = Part(classroom)
    entering = []
    for student in students:
        entering.append(asyncio.create_task(student.enter()))
        await asyncio.sleep(COMES)
    await asyncio.gather(*entering)
    tasks = [asyncio.create_task(student.listen()) for student in students]
    tasks += [asyncio.create_task(student.look()) for student in students]
    await asyncio.gather(*(student.changed.wait() for student in students))
    part.print("all come", max(student.began for student in students))
    part = Part(classroom)
    asked = time.perf_counter()
    flocks = {student.number: student.told["flock"] for student in students}
    await press_control(session, classroom.link, cookie, {"do": "ask", "question": QUESTION})
    while any(student.told["flock"] == flocks[student.number] for student in students):
        await asyncio.sleep(0.05)
    part.print("a question is asked", time.perf_counter() - asked)
    part = Part(classroom)
    handing = []
    for student in students:
        handing.append(asyncio.create_task(student.hand_in(0.01 * (student.number % 100))))
        await asyncio.sleep(over / count)
    await asyncio.gather(*handing)
    part.print("all hand in", max(student.waited for student in students))
    waits = sorted(student.waited for student in students)
    print(f"  a result, median          {statistics.median(waits):8.2f} s")
    print(f"  looks at the results      {sum(student.plots for student in students):8d}")
    shown = (await roster(session, classroom, cookie))["question"]
    print(f"  results                   {len(shown['points']):8d}")
    part = Part(classroom)
    await asyncio.sleep(5.0)
    part.print("nothing happens", 0.0)
    print(f"  memory, MB                {classroom.memory():8.0f}", flush=True)
    for task in (*tasks, teacher):
        task.cancel()


async def roster(
    session: aiohttp.ClientSession, classroom: Class, cookie: dict[str, str]
) -> dict[str, Any]:
    """What the teacher's page is told now."""
    base = classroom.link.rpartition("/")[0]
    async with session.get(f"{base}/class/roster", headers=cookie) as line:
        async for row in line.content:
            if row.startswith(b"data: "):
                found: dict[str, Any] = json.loads(row[6:])
                return found
    raise RuntimeError("the class tells nothing")


async def listen_to_roster(
    session: aiohttp.ClientSession, classroom: Class, cookie: dict[str, str]
) -> None:
    """Hear of the class as the teacher's page does."""
    base = classroom.link.rpartition("/")[0]
    async with session.get(f"{base}/class/roster", headers=cookie) as line:
        async for _ in line.content.iter_any():
            pass


class Part:
    """A part of a class, from now on."""

    def __init__(self, classroom: Class):
        classroom.find_processes()
        self.classroom = classroom
        self.began, self.bytes = time.perf_counter(), Counted.bytes
        self.seconds = classroom.seconds()

    def print(self, words: str, waited: float) -> None:
        """Print what it took."""
        lasted = time.perf_counter() - self.began
        spent = [b - a for a, b in zip(self.seconds, self.classroom.seconds(), strict=True)]
        sent = 1e-6 * (Counted.bytes - self.bytes)
        print(
            f"  {words:<24}  {lasted:8.1f} s, the last waited {waited:.1f} s; "
            f"cores {sum(spent) / lasted:.2f} (the front {spent[0] / lasted:.2f}), "
            f"sent {sent:.1f} MB"
        )
