"""Every command with every option, given what nobody should give: one line or a result, no crash.

The calls are made in this process. What a command would do at length (run, serve, trim, drive,
compute a paper) is replaced by a stand-in, so that only what is checked before is at work.
"""

import random

import pytest

from app.cli.main import COMMANDS, load
from cli.calling import call

HUGE = "9" * 40
VALUES = (
    "", " ", "0", "-1", HUGE, f"-{HUGE}", "1e400", "nan", "inf", "-inf", "1e-320", "0x10", "1_000",
    "٣", "½", "wrap", "vem",
    "a=b", "eta=1", f"eta={HUGE}", "eta=", "=", "p1=" + "9" * 5000, ",", ",,",
    "1,2", "1,2,3,4", "1,nan",
    "x" * 5000, "naïve \U0001f426", "\udcff", "a\x00b", "a\nb", "\x1b[31m",
    "--help-me", "/", "/dev/full", "/dev/null", "/proc/self/mem", ".", "..", "no/such/file.toml",
    "folder", "binary.toml",
    "binary.parquet", "binary.dxf", "deep.toml", "dotted.toml", "empty.toml",
    "wide.toml", "long.toml", "list.toml", "empty.parquet", "empty.parquet.part", "empty.wkt",
    "empty.geojson", "deep.geojson",
)  # fmt: skip
"""Texts that are given as the value of every option and argument."""
EACH = 8
"""Values that each option is given, drawn from the command's name."""
FILES = {
    "binary.toml": b"\x00\xff\xfe\x80" * 50,
    "binary.parquet": b"PAR1\x00\xff\xfe" * 50,
    "binary.dxf": b"\x00\xff\xfe\x80" * 50,
    "deep.toml": b"x = " + b"[" * 100_000,
    "dotted.toml": b"a." * 100_000 + b"b = 1",
    "empty.toml": b"",
    "wide.toml": b"model = 'vem'\nsize = 1e300\nagents = " + b"9" * 400,
    "long.toml": b"model = 'vem'\nseed = " + b"9" * 5000,
    "list.toml": b"model = ['vem']\nworld = 3\nsize = [[1]]\nedges = [1]\nlow = ['x']\n",
    "empty.parquet": b"",
    "empty.parquet.part": b"",
    "empty.wkt": b"",
    "empty.geojson": b"",
    "deep.geojson": b"[" * 100_000,
}
GIVEN = {
    "run": ["vem"],
    "paper": ["liu2021-table1"],
    "world show": ["wrap"],
    "world check": ["wrap"],
    "world import": ["empty.wkt", "--out", "out.toml"],
    "world make": ["discs", "--out", "out.toml"],
}
"""What a command is given beside the wrong value, so that this one is reached."""


class Reached(Exception):
    """A command has taken everything for right and would begin."""


def stop(*_, **__):
    raise Reached


@pytest.fixture(autouse=True)
def place(tmp_path, monkeypatch):
    """A folder of odd files; nothing is computed, served or driven."""
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    (tmp_path / "folder").mkdir()
    monkeypatch.chdir(tmp_path)
    for thing in (
        "app.cli.run.compile_loop", "app.cli.paper.carry_out_paper", "app.cli.lab.serve",
        "app.cli.classroom.serve",
        "app.cli.live.lab.serve", "app.cli.live.run.run_laboratory",
        "app.cli.live.check.look_at_devices",
        "app.live.operating.flock_driver.FlockDriver",
        "app.cli.formation.energy_per_metre", "app.flight.compared_flight.fly_pushed",
        "app.flight.trim_report.sweep_speeds", "app.flight.load.compute_loads",
        "agents.flight.trim.trim",
        "app.worlds.world_picture.draw_world",
        "app.formation.table", "agents.observables.formation.vee_saved",
        "app.cli.live.commands.emulate", "webbrowser.open", "app.cli.take.source.compile_loop",
    ):  # fmt: skip
        monkeypatch.setattr(thing, stop)
    return tmp_path


def commands():
    """Every command that can be called, with its parameters."""
    for name in COMMANDS:
        command = load(name)
        for part, one in getattr(command, "commands", {"": command}).items():
            yield f"{name} {part}".strip(), one.params


def calls(name, params):
    """Argument lists: each option with each value, and a draw of several at once."""
    beside = GIVEN.get(name, [])
    options = [one.opts[0] for one in params if one.opts[0].startswith("--")]
    flags = {one.opts[0] for one in params if getattr(one, "is_flag", False)}
    draw = random.Random(name)
    for value in VALUES:
        yield [*name.split(), value]
    for option in options:
        if option not in flags and option != "--help" and option not in beside:
            for value in draw.sample(VALUES, EACH):
                yield [*name.split(), *beside, option, value]
    for _ in range(20):
        words = [draw.choice([*options, *VALUES]) for _ in range(draw.randint(1, 6))]
        yield [*name.split(), *(word for word in words if word != "--help")]


@pytest.mark.parametrize(("name", "params"), [pytest.param(*one, id=one[0]) for one in commands()])
def test_no_value_makes_a_command_crash(name, params, place):
    count = refused = 0
    for args in calls(name, params):
        try:
            result = call(*args)
        except Reached:
            continue
        except Exception as error:
            raise AssertionError(f"flockscope {args} ends with {error!r}"[:2000]) from error
        finally:
            count += 1
        assert result.exit_code in (0, 2), args
        assert "Traceback" not in result.stderr, args
        if result.exit_code == 2 and name != "world check":
            refused += 1
            *before, line, end = result.stderr.split("\n")
            assert end == "", args
            assert line.startswith("flockscope: "), args
            assert len(line) < 2000, args
            assert "\x1b" not in line, args
            if name != "world import":  # which tells first what each layer is
                assert all(one.startswith(("flockscope: ", "written: ")) for one in before), args
    print(f"{name}: {count} calls, {refused} refused")
    assert {path.name for path in place.iterdir()} >= {*FILES, "folder"}
    for name, content in FILES.items():
        assert (place / name).read_bytes() == content
