"""What becomes of each command that a page prints: run, run otherwise, or not run, and why."""

from __future__ import annotations

import re
import shlex
from dataclasses import dataclass

NOT_RUN = {
    "pip install uv": "asks a package index; uv is what runs these tests",
    "uv run pytest": "is what runs now",
    'uv tool install ".[live]"': "asks a package index for what builds the package",
    'pip install ".[live]"': "asks a package index for what builds the package",
    "uv build --wheel": "asks a package index for what builds the package",
    "uv run python packing/release.py --out dist": "takes an hour: tests/packing/test_release.py",
    "pip download --no-deps trajectorytools==0.4.2": "asks a package index",
    "python -m zipfile -e trajectorytools-0.4.2-py3-none-any.whl .": "needs what that brings",
    "python benchmarks/studies/measured_flow.py 040_c_56_h-.txt --line -1.1": (
        "needs the file of the experiment: tests/papers/test_adrian2020.py runs it on another"
    ),
    "uv run python docs/learn_to_evade.py --out learning.png": (
        "takes half a minute: tests/test_learning.py runs two generations of it"
    ),
    "uv run python docs/controller.py": (
        "waits to be asked: tests/test_controllers.py has it steer a run"
    ),
    "uv run python docs/learn_to_evade.py --policy evade.py": (
        "takes a minute: tests/test_policies.py flies what it writes"
    ),
    "git clone --depth 1 https://github.com/PedestrianDynamics/jupedsim": "asks the network",
    "curl -X POST -H 'X-Flockscope: stop' http://localhost:8080/emergency": (
        "needs a room that is open: tests/attacks/test_stop_way.py presses it so"
    ),
}
"""Commands as they are printed -> why no test runs them."""


@dataclass(frozen=True)
class Otherwise:
    """Commands that begin with `words` are run with the options `more`, or, with None, only parsed.

    Parsed means: the command, its options and the kinds of their values are taken by the command
    line as printed, and nothing is done.
    """

    words: str
    more: str | None
    why: str


OTHERWISE = (
    Otherwise("docs", None, "needs the built site: tests/cli/test_docs_command.py opens one"),
    Otherwise(
        "export --all", None, "takes many minutes: tests/cli/test_export.py writes two of it"
    ),
    Otherwise("film", "--renderer plain", "tests/browser/test_take.py has a browser draw"),
    Otherwise("picture", "--renderer plain", "tests/browser/test_take.py has a browser draw"),
    Otherwise(
        "lab --host 0.0.0.0", "--host 127.0.0.1 --port 0 --open", "tests serve this machine only"
    ),
    Otherwise(
        "lab",
        "--port 0 --open",
        "the port may be taken here; what is opened is no browser but a test that reads the page",
    ),
    Otherwise(
        "class --host 0.0.0.0 --certificate",
        None,
        "needs a certificate: tests/classroom/test_class.py refuses one that is none",
    ),
    Otherwise(
        "class",
        "--host 127.0.0.1 --port 0 --open",
        "tests serve this machine only; a test reads the page, no browser",
    ),
    Otherwise(
        "sweep run vem --vary eta=0,0.628,1.257,1.885,2.513,3.142,3.77,4.398,5.027,5.655,6.283",
        "--runs 2",
        "fewer runs: twenty of each take longer",
    ),
    Otherwise("sweep run hwvem --vary", "--runs 2", "fewer runs: twenty of each take longer"),
    Otherwise("sweep run couzin --vary", "--runs 2", "fewer runs: twenty of each take longer"),
    Otherwise(
        "live lab lab.toml",
        '--source "emulated cars" --port 0',
        "needs the room's hardware; a test reads the page, no browser",
    ),
    Otherwise("live lab", "--port 0", "as the laboratory: no browser, and a port that is free"),
    Otherwise(
        "live check lab.toml",
        '--source "emulated cars" --within 300',
        "needs the room's hardware; a busy machine takes long to start what stands for it",
    ),
    Otherwise(
        "live check trial.c3d?body=car1,rear,front&unit=mm",
        None,
        "no page prints a C3D file: tests/cli/test_live_recordings.py",
    ),
    Otherwise("live run lab.toml --source", "--seconds 1", "would wait for a key: nobody is at it"),
    Otherwise(
        "live run lab.toml", '--source "emulated cars" --seconds 1', "needs the room's hardware"
    ),
    Otherwise(
        "live recover",
        None,
        "needs a process that was killed: tests/live/test_end_to_end.py kills it",
    ),
    Otherwise(
        "live emulate --arm --seconds 20 --record",
        "--seconds 5",
        "shorter: 20 s are for people to look at",
    ),
    Otherwise("live emulate --arm", None, "docs/live.md runs it and records it"),
    Otherwise("live emulate", "--seconds 1", "would wait for a key: nobody is at it"),
    Otherwise(
        "flight trim --speed 3.5 --frequency", None, "options by name that another page leaves out"
    ),
    Otherwise("flight sweep", None, "takes a minute; tests/flight/test_commands.py sweeps"),
    Otherwise("flight simulate", None, "takes half a minute; tests/flight/test_commands.py flies"),
    Otherwise(
        "formation vee --birds", "--draws 20 --no-pictures", "another page draws the picture"
    ),
    Otherwise("formation vee", "--draws 20", "fewer draws: a thousand take ten seconds"),
    Otherwise("paper couzin2002-phases", None, "84 rows; tests/papers/test_couzin2002.py has some"),
    Otherwise("paper couzin2005-leadership", None, "minutes; test_couzin2005.py has some"),
    Otherwise("paper couzin2002-sorting", None, "350 runs; tests/papers/test_couzin2002.py has 28"),
    Otherwise(
        "paper formation-echelon", None, "minutes; tests/experiments/test_missions.py reads it"
    ),
    Otherwise("paper guarded-alpha", None, "3000 ticks a run; tests/test_guarded.py flies some"),
    Otherwise("paper thesis-table5.2", None, "as table 5.1, which is run, but longer"),
    Otherwise("paper thesis-fig5.7", None, "as figure 5.4, which is run, but longer"),
    Otherwise("paper jacobs-fig11", None, "tests/papers/test_jacobs.py repeats some of its rows"),
    Otherwise("paper liu2021-table1 --runs 20", None, "its first rows are run without it"),
    Otherwise("paper liu2021-table1", "--runs 2 --agents 100", "all rows take minutes to hours"),
    Otherwise("paper liu2021-table2", "--runs 2 --agents 5", "all rows take minutes to hours"),
    Otherwise(
        "paper liu2021-weights",
        None,
        "minutes; tests/papers/test_liu2021_weights.py has some",
    ),
    Otherwise(
        "paper gregoire-chate2004",
        None,
        "12 000 ticks a run; tests/experiments/test_ordering.py makes shorter ones",
    ),
    Otherwise("paper vicsek1995-fig2", None, "as vicsek1995-headings, which is run, but longer"),
    Otherwise("paper thesis-delay", None, "as liu2021-delay, which is run, but longer"),
    Otherwise("paper wu2023-delay", None, "as liu2021-delay, which is run, but longer"),
    Otherwise("paper --all", None, "minutes; tests/cli/test_paper.py runs some of them"),
    Otherwise(
        "paper",
        "--runs 2 --no-pictures",
        "two runs a row; pictures are drawn of the two tables above",
    ),
)
"""The first that fits counts."""


class NotAsPrintedError(Exception):
    """A line that a reader's shell would not take as it is meant."""


def commands(line: str) -> list[str]:
    """The commands of a printed line: what stands between `&&`. Raises NotAsPrintedError.

    Refused is what only some shells take, or what means something else to them: a comment behind
    a command, brackets around what may be left out, a placeholder.
    """
    try:
        shlex.split(line)
    except ValueError as error:
        raise NotAsPrintedError(f"{error} in {line!r}") from None
    bare = re.sub(r'"[^"]*"|\'[^\']*\'', "", line)
    odd = sorted(set(re.findall(r"[#\[\]?*<>|;$`(){}!~^]", bare)) | set(re.findall("…", bare)))
    if odd:
        raise NotAsPrintedError(f"a shell would read {' '.join(odd)} in {line!r} for itself")
    return [command.strip() for command in line.split("&&")]


def arguments(command: str) -> list[str]:
    """What a printed command gives to flockscope. Raises NotAsPrintedError if it is not called so.

    Without any command flockscope opens the laboratory.
    """
    words = shlex.split(command.removeprefix("uv run --no-dev "))
    if words[:1] != ["flockscope"]:
        raise NotAsPrintedError(f"{command!r} is neither run nor named in {__file__} with a reason")
    return words[1:] or ["lab"]


def altered(words: list[str], more: str) -> list[str]:
    """A command with other options, in place of those that it has."""
    made, rest = list(words), shlex.split(more)
    for option in [one for one in rest if one.startswith("--")]:
        for name in (option, option.replace("--", "--no-", 1)):
            if name in made:
                at = made.index(name)
                has_value = at + 1 < len(made) and not made[at + 1].startswith("--")
                del made[at : at + 1 + has_value]
    return [*made, *rest]


def otherwise(words: list[str]) -> Otherwise | None:
    """How a command is run if not as it is printed."""
    for one in OTHERWISE:
        start = shlex.split(one.words)
        if words[: len(start)] == start:
            return one
    return None
