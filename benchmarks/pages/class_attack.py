"""What students wait for their results while others hand in all that takes long.

    uv run python benchmarks/pages/class_attack.py [--dishonest 1 3 10] [--honest 10] [--seconds 20]

Starts `flockscope class` with flocks of 300 agents (hwvem) and a question about how many there are.
Honest students hand in their run every three seconds. Dishonest ones open runs that take as long as
they can and hand them in as often as they are let, all the time: agents of whom each pair takes a
thousand times what it usually does; as many pairs as may be handed in; and 2 000 agents on a side
of 1. One more student is honest and slow. Before they begin, all of them look at flocks of theirs
for as long. Prints for each number of dishonest ones how long the honest waited before and then;
what became of the runs of the others; how long the teacher waited for a picture and for the class's
file, and how often the class was not kept.
"""

from __future__ import annotations

import argparse
import asyncio
import statistics
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

import aiohttp
from classroom import Class, Student, press_control, teach

sys.path.insert(0, str(Path(__file__).parents[2]))

from app.viewer.gallery.saved_scene import SavedScene, pack_scene
from app.viewer.run.run_preset import preset_spec

AGENTS = 300
FEWEST = 3
"""Results of honest students before a part of a class ends."""
APART = 3.0
"""Seconds between two results of an honest student."""
QUESTION = {
    "title": "Order against agents",
    "parameter": "agents",
    "measure": {"observe": "polarisation", "over": 100},
    "ticks": 500,
}
SLOW = preset_spec("hwvem", agents=1500, size=8.0)
LONG = (
    preset_spec("squashing-best", agents=500, size=20.0, world="wrap"),
    preset_spec("hwvem", agents=2000, size=7.8),
    preset_spec("hwvem", agents=2000, size=1.0),
)
WAITS = aiohttp.ClientTimeout(total=300.0)


@dataclass
class Waits:
    """What came of one class."""

    quiet: list[float] = field(default_factory=list)
    """Seconds that honest students waited for a result before others attacked,"""
    honest: list[float] = field(default_factory=list)
    """and then."""
    begun: bool = False
    """Whether others attack."""
    refused: list[str] = field(default_factory=list)
    """What honest ones were told that got none."""
    others: Counter[str] = field(default_factory=Counter)
    """What became of the runs of the dishonest and the slow."""
    teacher: list[float] = field(default_factory=list)
    """Seconds for a picture, and for the class's file."""
    not_kept: int = 0


class Handing(Student):
    """A student who hands in runs."""

    async def hand_in(self, session: aiohttp.ClientSession, base: str) -> tuple[int, str, float]:
        """Hand in: status, words and seconds."""
        headers = {"Cookie": self.cookies, "Origin": base, "X-Flockscope": "class"}
        began = time.perf_counter()
        async with session.post(
            f"{base}/class/hand-in", json={}, headers=headers, timeout=WAITS
        ) as answer:
            text = await answer.text()
            return answer.status, text.strip(), time.perf_counter() - began

    async def open(self, session: aiohttp.ClientSession, base: str, spec: object) -> None:
        """Open a run in one's own flock."""
        headers = {"Cookie": self.cookies, "X-Flockscope": "scene"}
        at = f"{base}/open?sure=1&scene={pack_scene(SavedScene('A run', spec))}"  # type: ignore[arg-type]
        while True:
            async with session.get(at, headers=headers) as answer:
                if answer.status == 200:
                    return
            await asyncio.sleep(0.5)

    async def honest(self, session: aiohttp.ClientSession, base: str, waits: Waits) -> None:
        """Hand in now and then."""
        await asyncio.sleep(APART * self.number / 10 % APART)
        while True:
            status, text, took = await self.hand_in(session, base)
            if status == 200:
                (waits.honest if waits.begun else waits.quiet).append(took)
            else:
                waits.refused.append(text)
            await asyncio.sleep(APART)

    async def other(
        self, session: aiohttp.ClientSession, base: str, waits: Waits, who: str, apart: float
    ) -> None:
        """Hand in again and again."""
        while True:
            status, text, _ = await self.hand_in(session, base)
            ends = ("was ended: wait", "hand in again in", "too long for", "too much at once")
            what = next(
                (end for end in ends if end in text), "refused" if status != 200 else "made"
            )
            waits.others[f"{who}: {what}"] += 1
            await asyncio.sleep(apart)


async def teacher_waits(
    session: aiohttp.ClientSession, base: str, cookie: dict[str, str], waits: Waits
) -> None:
    """Ask for what the teacher takes along, again and again."""
    while True:
        for path in ("results.png", "class.zip"):
            began = time.perf_counter()
            async with session.get(f"{base}/class/{path}", headers=cookie, timeout=WAITS) as answer:
                await answer.read()
                if answer.status == 200:
                    waits.teacher.append(time.perf_counter() - began)
        await asyncio.sleep(4.0)


async def measure(honest: int, dishonest: int, slow: int, seconds: float) -> Waits:
    """One class with so many of each."""
    waits = Waits()
    with tempfile.TemporaryDirectory() as folder, open(Path(folder) / "said", "w+") as output:
        classroom = Class(folder, AGENTS, honest + dishonest + slow, output)
        try:
            connector = aiohttp.TCPConnector(limit=0)
            jar = aiohttp.DummyCookieJar()
            async with aiohttp.ClientSession(connector=connector, cookie_jar=jar) as session:
                await attack(session, classroom, waits, (honest, dishonest, slow), seconds)
        finally:
            classroom.end()
        output.seek(0)
        waits.not_kept = output.read().count("is not kept")
    return waits


async def attack(
    session: aiohttp.ClientSession,
    classroom: Class,
    waits: Waits,
    counts: tuple[int, int, int],
    seconds: float,
) -> None:
    """Have all of them hand in for so many seconds."""
    base = classroom.link.rpartition("/")[0]
    cookie = await teach(session, classroom.teachers)
    await press_control(session, classroom.link, cookie, {"do": "role", "role": "own"})
    students = [Handing(number, AGENTS) for number in range(sum(counts))]
    for student in students:
        await student.enter(session, classroom.link)
    tasks = [asyncio.create_task(student.read()) for student in students]
    await press_control(session, classroom.link, cookie, {"do": "ask", "question": QUESTION})
    first, last = counts[0], counts[0] + counts[1]
    while (await students[0].hand_in(session, base))[0] != 200:  # all is compiled then
        await asyncio.sleep(0.5)
    tasks += [
        asyncio.create_task(student.honest(session, base, waits)) for student in students[:first]
    ]
    tasks.append(asyncio.create_task(teacher_waits(session, base, cookie, waits)))
    await wait_for_results(seconds, waits.quiet)
    for number, student in enumerate(students[first:last]):
        await student.open(session, base, LONG[number % len(LONG)])
        tasks.append(asyncio.create_task(student.other(session, base, waits, "dishonest", 0.2)))
    for student in students[last:]:
        await student.open(session, base, SLOW)
        tasks.append(asyncio.create_task(student.other(session, base, waits, "slow", APART)))
    waits.begun = True
    await wait_for_results(seconds, waits.honest)
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)
    await asyncio.gather(*(student.line.close() for student in students))


async def wait_for_results(seconds: float, results: list[float]) -> None:
    """Wait so long, and until there are a few results: on a busy machine that is longer."""
    await asyncio.sleep(seconds)
    while len(results) < FEWEST:
        await asyncio.sleep(0.5)


def main() -> None:
    """Measure and print."""
    asking = argparse.ArgumentParser(description="What students wait while others attack.")
    asking.add_argument("--dishonest", type=int, nargs="+", default=[1, 3, 10])
    asking.add_argument("--honest", type=int, default=10)
    asking.add_argument("--seconds", type=float, default=20.0)
    options = asking.parse_args()
    for dishonest in options.dishonest:
        result = asyncio.run(measure(options.honest, dishonest, 1, options.seconds))
        print(f"{options.honest} honest, {dishonest} dishonest and one slow student")
        for what, took in (("before", result.quiet), ("attacked", result.honest)):
            if took:
                print(
                    f"  {what:9} {len(took):4} results waited for {statistics.mean(took):6.2f} s "
                    f"(longest {max(took):.2f})"
                )
        if result.quiet and result.honest:
            times = statistics.mean(result.honest) / statistics.mean(result.quiet)
            print(f"  times as long                    {times:6.2f}")
        print(f"  honest without a result          {len(result.refused):6}")
        for what, count in sorted(result.others.items()):
            print(f"  {what:32} {count:6}")
        if result.teacher:
            print(f"  the teacher waited at most       {max(result.teacher):6.2f} s")
        print(f"  not kept                         {result.not_kept:6}", flush=True)


if __name__ == "__main__":
    main()
