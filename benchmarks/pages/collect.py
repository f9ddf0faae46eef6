"""What a result costs that a student hands in, and what the end of a class costs.

    uv run python benchmarks/pages/collect.py [--students 40] [--pairs]

Vicsek agents: 300, 500 ticks, the polarisation over the last 100, against noise; and HWVEM: ticks
until all agree. A result is made as by the process that the class has for it: the run, its
measure, how it differs from the class's scene, its spec. Then the picture, the plot of the page,
and the file of the whole class, saved and opened again. Milliseconds by the clock of one process
that has compiled already. With --pairs instead: nanoseconds for each pair of agents that a run of
each model looks at, as `app/classroom/collect/run_cost.py` counts them, in its own world and
crowded.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median

sys.path.insert(0, str(Path(__file__).parents[2]))

from agents import Flock
from agents.catalogue import MODELS
from agents.spec import CompleteSpec
from app.classroom.class_file import ClassState, SavedStudent, load, save
from app.classroom.collect.class_picture import FORMATS, picture
from app.classroom.collect.class_table import to_json
from app.classroom.collect.collection import Collection
from app.classroom.collect.hand_in import Point, hand_in, run_of, warm_up
from app.classroom.collect.question import Question
from app.classroom.collect.question_choices import ready_for
from app.classroom.collect.run_cost import MOST_PAIRS, mean_neighbours
from app.classroom.student import Role
from app.viewer.gallery.saved_scene import SavedScene
from app.viewer.run.run_preset import preset_spec
from worlds.input_error import InputError


def time_call[Made](work: Callable[[], Made]) -> tuple[Made, float]:
    """What a call gives, and the milliseconds that it took."""
    started = time.perf_counter()
    result = work()
    return result, 1e3 * (time.perf_counter() - started)


def collect_answers(question: Question, scene: CompleteSpec, students: int) -> Collection:
    """A class's results, and what each of them cost, printed."""
    collection = Collection(question)
    warm_up(question, scene)
    whole, alone = [], []
    for number in range(students):
        name = f"Student {number}"
        spec = collection.begins(name, scene)
        alone.append(time_call(lambda spec=spec: run_of(question, spec, spec.seed))[1])
        point: Point
        point, took = time_call(lambda spec=spec, name=name: hand_in(question, name, spec, scene))
        whole.append(took)
        collection.add(point)
    print(
        f"{question.title}, {scene.model}, {scene.agents} agents: {median(whole):.1f} ms a result "
        f"(longest {max(whole):.1f}), of which {median(alone):.1f} the run"
    )
    return collection


CROWDED = 600
"""Agents in a box as small as the model allows."""
TICKS = 20


def time_pairs() -> None:
    """Print what a pair costs in each model, and what the most pairs of a run would then take."""
    slowest = 0.0
    for name, model in MODELS.items():
        home = preset_spec(name)
        reach = getattr(Flock(home).parameters, model.rule.reach or "", None)
        crowded = home if reach is None else home.but(agents=CROWDED, size=2.0 * reach)
        times = []
        for spec in (home, crowded):
            try:
                flock = Flock(spec)
                flock.run(TICKS)  # compiles
                _, took = time_call(lambda flock=flock: flock.run(TICKS))
            except InputError:
                times.append("cannot be crowded: its world has a size of its own")
                continue
            pairs = spec.count * max(1.0, mean_neighbours(spec)) * TICKS
            times.append(f"{1e6 * took / pairs:8.2f} ns of {pairs / TICKS:9.0f} pairs a tick")
            if spec is crowded:
                slowest = max(slowest, took / pairs)
        print(f"{name:18} " + "; ".join(times))
    print(
        f"{MOST_PAIRS:.1g} pairs of the slowest model, crowded: {1e-3 * slowest * MOST_PAIRS:.1f} s"
    )


def main() -> None:
    """Print what results, their picture and the file of the class cost."""
    arguments = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    arguments.add_argument("--students", type=int, default=40, help="of the class")
    arguments.add_argument("--pairs", action="store_true", help="what a pair costs, instead")
    options = arguments.parse_args()
    if options.pairs:
        time_pairs()
        return
    students = options.students
    vem = preset_spec("vem", agents=300)
    led = preset_spec("hwvem", agents=300)
    order = next(item.question for item in ready_for(vem) if item.name == "order-against-noise")
    agree = next(item.question for item in ready_for(led) if item.name == "who-leads")
    collection = collect_answers(order, vem, students)
    collect_answers(agree, led, students)
    json_time, took = time_call(lambda: json.dumps(to_json(collection)))
    print(f"the plot of the page: {took:.1f} ms, {len(json_time):,} bytes")
    picture(collection, "png")
    for kind in FORMATS:
        picture_time, took = time_call(lambda kind=kind: picture(collection, kind))
        print(f"the picture as {kind}: {took:.0f} ms, {len(picture_time):,} bytes")
    scene = SavedScene("Order", vem)
    names = list(collection.given)
    state = ClassState(
        "A class",
        scene,
        {name: SavedStudent(Role.OWN, scene) for name in names},
        [collection],
        students,
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "class.zip"
        _, saved = time_call(lambda: save(state, path))
        again, opened = time_call(lambda: load(path))
        if again != state:
            raise SystemExit("the class that was opened is not the one that was saved")
        print(
            f"the class's file: saved in {saved:.0f} ms, opened in {opened:.0f} ms, "
            f"{path.stat().st_size:,} bytes"
        )


if __name__ == "__main__":
    main()
