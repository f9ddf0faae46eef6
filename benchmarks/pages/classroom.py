"""What a class costs.

    uv run python benchmarks/pages/classroom.py [--students 10 20 40] [--watch | --in-browser]

Starts `flockscope class` with flocks of 300 agents (hwvem), and in a process of its own so many
students that are programs, not browsers: they enter by the code, connect through the front, read
every picture, and every three seconds pause their flock and let it go on at once. With `--watch`
all of them watch the teacher's run of 1 000 agents. Prints how long all took to begin, pictures a
second of a flock that is not paused, what was sent, how soon a button was answered, how soon the
teacher's page was, processor time and memory of the class without its students, and what a
laboratory costs at which nobody looks. With `--browsers N` so many students more are in browsers,
at the size of a phone: what they get is printed too.

With `--in-browser` flocks run in students' browsers: programs load the page and what runs in it,
listen to the class, hand in within `--over` seconds, and fetch the results as they grow; the
teacher's page listens too. Printed are processor time and bytes of each part of that, and the
memory of the class: how soon a browser draws does not depend on it.
"""

from __future__ import annotations

import argparse
import asyncio
import re
import statistics
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

import aiohttp
import msgspec
import psutil
import viser
import zstandard
from aiohttp.client_proto import ResponseHandler
from class_pages import Page, pages
from stream import CAMERA

SCENE = """
title = "Benchmark"
speed = 30.0
[run]
model = "hwvem"
agents = {agents}
seed = 1
[run.parameters]
eta = 0.3
"""
PRESS = 3.0
"""Seconds between two presses of a student."""
PRESSES = 5
"""Of each student in a browser."""
SETTLES = 4.0
"""Seconds from the last that began to the measurement."""
unzstd = zstandard.ZstdDecompressor()


class Student:
    """One who enters, looks and presses."""

    def __init__(self, number: int, agents: int):
        self.number = number
        self.least = 12 * agents
        """Bytes of a message with a picture in it."""
        self.pictures = 0
        self.began = 0.0
        """When the first picture was there, s since it entered."""
        self.button = self.cookies = ""
        self.pressed = self.paused = self.stood = 0.0
        """When it pressed last, s; since when its flock is paused, and how long it was so far."""
        self.answers: list[float] = []

    async def enter(self, session: aiohttp.ClientSession, link: str) -> None:
        """Enter by the code, and connect."""
        self.entered = time.perf_counter()
        base, _, code = link.rpartition("/")
        values = {"code": code, "name": f"Student {self.number}"}
        headers = {"Origin": base}
        async with session.post(
            f"{base}/join", data=values, headers=headers, allow_redirects=False
        ) as answer:
            assert answer.status == 303, await answer.text()
            self.cookies = "; ".join(
                f"{cookie.key}={cookie.value}" for cookie in answer.cookies.values()
            )
        self.line = await session.ws_connect(
            base,
            protocols=(f"viser-v{viser.__version__}",),
            headers={"Cookie": self.cookies},
            max_msg_size=0,
            compress=15,
        )
        await self.line.send_bytes(msgspec.msgpack.encode(CAMERA))

    async def read(self) -> None:
        """Read whatever comes."""
        async for message in self.line:
            now, data = time.perf_counter(), message.data
            if len(data) > self.least:
                self.pictures += 1
                self.began = self.began or now - self.entered
            if not self.button:
                self.button = next(
                    (message["uuid"] for message in decode_messages(data)
                     if message["type"] == "GuiButtonMessage"
                     and message["props"]["label"] in ("Pause", "Go")), "",
                )  # fmt: skip
            elif self.pressed and (label := self.label(data)):
                if label == "Go":
                    self.answers.append(now - self.pressed)
                    self.paused = now
                    await self.say()
                elif self.paused:
                    self.stood += now - self.paused
                    self.pressed = self.paused = 0.0

    def label(self, data: bytes) -> str:
        """What the button is called from now on; empty if nothing is said of that."""
        updates = (
            message for message in decode_messages(data) if message.get("uuid") == self.button
        )
        return next(
            (update["updates"]["label"] for update in updates if "label" in update["updates"]), ""
        )

    async def say(self) -> None:
        """Press the button that starts and pauses."""
        update = {"type": "GuiUpdateMessage", "uuid": self.button, "updates": {"value": True}}
        await self.line.send_bytes(msgspec.msgpack.encode(update))

    async def press(self) -> None:
        """Pause now and then; once that is answered the flock goes on."""
        await asyncio.sleep(PRESS * (self.number % 10) / 10)
        while True:
            await asyncio.sleep(PRESS)
            if self.button and not self.pressed:
                self.pressed = time.perf_counter()
                await self.say()


def decode_messages(data: bytes) -> list[dict[str, Any]]:
    """The messages in what viser sends."""
    whole, size = (int.from_bytes(data[at : at + 8], "little") for at in (0, 8))
    plain = unzstd.decompress(data[16 : 16 + size], max_output_size=whole)
    messages: list[dict[str, Any]] = msgspec.msgpack.decode(plain)["messages"]
    return messages


class Counted(ResponseHandler):
    """A connection whose bytes are counted as they come, packed."""

    __slots__ = ()
    bytes = 0

    def data_received(self, data: bytes) -> None:
        """Count, and go on."""
        Counted.bytes += len(data)
        super().data_received(data)


class Class:
    """The command, from outside."""

    def __init__(
        self, folder: str, agents: int, seats: int, output: Any = None, flocks: str = "on-server"
    ):
        (Path(folder) / "scene.toml").write_text(SCENE.format(agents=agents))
        command = [sys.executable, "-m", "flockscope", "class", "scene.toml", "--port", "0"]
        self.process = subprocess.Popen(
            [*command, "--no-open", "--students", str(seats), "--flocks", flocks],
            cwd=folder,
            stdout=subprocess.PIPE,
            stderr=output,
            text=True,
        )
        lines = [self.process.stdout.readline() for _ in range(2)]
        self.link = lines[0].split()[-1]
        match = re.search(r"alone: (\S+)", lines[1])
        assert match is not None, lines
        self.teachers = match[1]
        self.find_processes()

    def find_processes(self) -> None:
        """Find all processes that there are by now; the front's is the first."""
        self.all = [psutil.Process(self.process.pid)]
        self.all += self.all[0].children(recursive=True)

    def seconds(self) -> list[float]:
        """Processor time of each process so far, s; the front's first."""
        return [sum(process.cpu_times()[:2]) for process in self.all]

    def memory(self) -> float:
        """Memory of all processes, what they share counted once, MB."""
        return 1e-6 * sum(process.memory_full_info().pss for process in self.all)

    def end(self) -> None:
        """End it."""
        self.process.terminate()
        self.process.wait(30)


async def teach(session: aiohttp.ClientSession, link: str) -> dict[str, str]:
    """The cookie of the teacher."""
    base, _, key = link.rpartition("/")
    headers = {"Origin": base}
    async with session.post(
        f"{base}/teach", data={"key": key}, headers=headers, allow_redirects=False
    ) as answer:
        return {
            "Cookie": "; ".join(
                f"{cookie.key}={cookie.value}" for cookie in answer.cookies.values()
            )
        }


async def press_control(
    session: aiohttp.ClientSession, link: str, cookie: dict[str, str], values: Any
) -> None:
    """What the teacher's page asks for."""
    base = link.rpartition("/")[0]
    headers = {**cookie, "Origin": base, "X-Flockscope": "class"}
    async with session.post(f"{base}/class/do", json=values, headers=headers) as answer:
        assert answer.status == 200, await answer.text()


async def page(
    session: aiohttp.ClientSession, link: str, cookie: dict[str, str], took: list[float]
) -> None:
    """Ask for the teacher's page, again and again."""
    base = link.rpartition("/")[0]
    while True:
        began = time.perf_counter()
        async with session.get(f"{base}/class", headers=cookie) as answer:
            await answer.read()
        took.append(time.perf_counter() - began)
        await asyncio.sleep(0.5)


async def measure(
    count: int, agents: int, watch: bool, seconds: float, idle: float, browsers: int
) -> None:
    """Measure a class of so many students, and print."""
    with tempfile.TemporaryDirectory() as folder:
        classroom = Class(folder, agents, count + browsers)
        try:
            connector = aiohttp.TCPConnector(limit=0)
            connector._factory = partial(Counted, loop=asyncio.get_running_loop())
            jar = aiohttp.DummyCookieJar()
            async with aiohttp.ClientSession(connector=connector, cookie_jar=jar) as session:
                cookie = await teach(session, classroom.teachers)
                if not watch:
                    await press_control(
                        session, classroom.link, cookie, {"do": "role", "role": "own"}
                    )
                async with pages(classroom.link, browsers) as opened:
                    await measure_class(
                        session, classroom, cookie, count, agents, watch, seconds, opened
                    )
            if not watch:
                await measure_empty_class(classroom, count + browsers, idle)
        finally:
            classroom.end()


async def measure_class(
    session: aiohttp.ClientSession,
    classroom: Class,
    cookie: dict[str, str],
    count: int,
    agents: int,
    watch: bool,
    seconds: float,
    opened: list[Page],
) -> None:
    """Measure a class that runs, and print."""
    students = [Student(number, agents) for number in range(count)]
    await asyncio.gather(*(student.enter(session, classroom.link) for student in students))
    took: list[float] = []
    tasks = [asyncio.create_task(student.read()) for student in students]
    tasks.append(asyncio.create_task(page(session, classroom.link, cookie, took)))
    while not all(student.began for student in students):
        await asyncio.sleep(0.05)
    began = max(student.began for student in students)
    if not watch:
        tasks += [asyncio.create_task(student.press()) for student in students]
    await asyncio.sleep(SETTLES)
    before, sent = classroom.seconds(), Counted.bytes
    pictures, answers = (
        [student.pictures for student in students],
        [len(student.answers) for student in students],
    )
    stood = [student.stood for student in students]
    took.clear()
    start = time.perf_counter()
    picture_counts = [await page.pictures() for page in opened]
    await asyncio.sleep(seconds)
    lasted = time.perf_counter() - start
    picture_counts = [
        await page.pictures() - was for page, was in zip(opened, picture_counts, strict=True)
    ]
    after, sent = classroom.seconds(), Counted.bytes - sent
    ran = [lasted - student.stood + was for student, was in zip(students, stood, strict=True)]
    rates = [
        (student.pictures - was) / time_
        for student, was, time_ in zip(students, pictures, ran, strict=True)
    ]
    delays = sorted(
        x for student, was in zip(students, answers, strict=True) for x in student.answers[was:]
    )
    cores = [(b - a) / lasted for a, b in zip(before, after, strict=True)]
    what = "watch the teacher's run of" if watch else "flocks of"
    print(f"{count} students, {what} {agents} agents")
    print(f"  all have a picture        {began:8.1f} s")
    print(f"  pictures/s                {statistics.mean(rates):8.1f} (least {min(rates):.1f})")
    if not watch:
        print(f"  paused                    {1 - statistics.mean(ran) / lasted:8.1%} of the time")
    print(f"  sent, Mbit/s              {8e-6 * sent / lasted:8.1f}")
    if delays:
        late = delays[min(len(delays) - 1, int(0.95 * len(delays)))]
        print(f"  a button answers          {late:8.2f} s at the 95th percentile of {len(delays)}")
    print(f"  the teacher's page        {max(took):8.2f} s at worst of {len(took)}")
    print(f"  cores                     {sum(cores):8.2f} (the front {cores[0]:.2f})")
    print(f"  memory, MB                {classroom.memory():8.0f}")
    if opened:
        await print_pages(opened, [count / lasted for count in picture_counts], watch)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*(student.line.close() for student in students))


async def print_pages(opened: list[Page], rates: list[float], watch: bool) -> None:
    """What students in browsers get, with pictures/s of each; all others run on meanwhile."""
    mean, least = statistics.mean(rates), min(rates)
    print(f"  in {len(opened)} browsers, pictures/s {mean:6.1f} (least {least:.1f})")
    if watch:
        return
    for _ in range(PRESSES):
        for page in opened:
            await page.press()
    late = max(answer for page in opened for answer in page.answers)
    print(f"  a button of theirs        {late:8.2f} s at worst of {PRESSES * len(opened)}")


async def measure_empty_class(classroom: Class, count: int, idle: float) -> None:
    """Measure a class whose students have gone, and print."""
    await asyncio.sleep(SETTLES)
    before = classroom.seconds()
    await asyncio.sleep(idle)
    spent = sum(b - a for a, b in zip(before, classroom.seconds(), strict=True)) / idle
    print(f"  nobody looks, cores each  {spent / count:8.4f}", flush=True)


def main() -> None:
    """Measure and print."""
    asking = argparse.ArgumentParser(description="What a class costs.")
    asking.add_argument("--students", type=int, nargs="+", help="10 20 40; 40 200 500 in browsers")
    asking.add_argument("--agents", type=int)
    asking.add_argument("--watch", action="store_true")
    asking.add_argument("--seconds", type=float, default=20.0)
    asking.add_argument("--idle", type=float, default=20.0, help="seconds, of nobody looking")
    asking.add_argument("--browsers", type=int, default=0, help="students more, in browsers")
    asking.add_argument("--in-browser", action="store_true", help="flocks run in browsers")
    asking.add_argument("--over", type=float, default=60.0, help="seconds in which all hand in")
    options = asking.parse_args()
    if options.in_browser:
        from class_in_browsers import measure_in_browsers

        for count in options.students or (40, 200, 500):
            asyncio.run(measure_in_browsers(count, options.over))
        return
    agents = options.agents or (1000 if options.watch else 300)
    for count in options.students or (10, 20, 40):
        asyncio.run(
            measure(count, agents, options.watch, options.seconds, options.idle, options.browsers)
        )


if __name__ == "__main__":
    main()
