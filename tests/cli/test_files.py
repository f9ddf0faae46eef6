"""What commands write: never over a device, over a file only when asked, whole, and named."""

import os
import stat
import subprocess
import sys
from pathlib import Path

import pyarrow.csv as pc
import pyarrow.parquet as pq
import pytest

from agents import Flock
from cli.calling import call, refusal
from worlds.file_writer import write_text, writing
from worlds.input_error import InputError

WRITERS = {
    "--save": (("run", "vem", "--ticks", 2, "--quiet", "--save"), "x.parquet"),
    "--record": (("run", "vem", "--ticks", 2, "--quiet", "--record"), "x.parquet"),
    "--save-spec": (("run", "vem", "--ticks", 2, "--quiet", "--save-spec"), "x.toml"),
    "make": (("world", "make", "discs", "--out"), "x.toml"),
    "import": (("world", "import", "room.wkt", "--quiet", "--out"), "x.toml"),
    "show": (("world", "show", "wrap", "--out"), "x.png"),
}
"""Every command that writes one file."""
FOLDERS = {
    "spacing": (("formation", "spacing"), "spacing.csv"),
    "map": (("formation", "map"), "map.png"),
    "vee": (("formation", "vee", "--energy", 1), "vee.svg"),
    "trim": (("flight", "trim"), "beat.csv"),
    "sweep": (("flight", "sweep"), "sweep.png"),
    "simulate": (("flight", "simulate"), "history.csv"),
    "paper": (("paper", "liu2021-table1", "--runs", 2), "summary.csv"),
}
"""Every command that writes a folder, and one of its files."""
writers = pytest.mark.parametrize(("args", "name"), WRITERS.values(), ids=list(WRITERS))
folders = pytest.mark.parametrize(("args", "name"), FOLDERS.values(), ids=list(FOLDERS))


@pytest.fixture(autouse=True)
def here(tmp_path, monkeypatch):
    (tmp_path / "room.wkt").write_text("wall: POLYGON ((0 0, 4 0, 4 1, 0 1, 0 0))\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@writers
def test_a_device_stays_a_device(args, name):  # noqa: ARG001
    for device in ("/dev/full", "/dev/null"):
        before = os.stat(device)
        assert f"'{device}' is a device, not a file to write" in refusal(*args, device)
        now = os.stat(device)
        assert stat.S_ISCHR(now.st_mode)
        assert (now.st_ino, now.st_rdev) == (before.st_ino, before.st_rdev)


@writers
def test_what_is_no_file_is_not_written_over(args, name, here):
    os.mkfifo(here / "pipe")
    (here / "folder").mkdir()
    (here / "loop").symlink_to("loop")
    (here / "null").symlink_to("/dev/null")
    for place, words in (("pipe", "is a pipe"), ("folder", "is a folder"), ("null", "is a device"),
                         ("loop", "leads nowhere"), ("no/" + name, "there is no folder 'no'"),
                         ("x" * 300 + name, "too long")):  # fmt: skip
        for more in ((), ("--overwrite",)):
            assert words in refusal(*args, place, *more)
    assert {path.name for path in here.iterdir()} == {"room.wkt", "pipe", "folder", "loop", "null"}
    assert stat.S_ISFIFO((here / "pipe").stat().st_mode)


@writers
def test_a_file_is_replaced_only_when_asked(args, name, here):
    path = here / name
    path.write_text("mine")
    assert "exists already: name another, or --overwrite" in refusal(*args, path)
    assert path.read_text() == "mine"
    path.chmod(0o640)
    assert call(*args, path, "--overwrite").exit_code == 0
    assert path.stat().st_size > 50
    assert stat.S_IMODE(path.stat().st_mode) == 0o640
    assert {one.name for one in here.iterdir()} == {"room.wkt", name}


@writers
def test_a_link_is_followed_to_its_file(args, name, here):
    (here / "far").mkdir()
    link, target = here / name, here / "far" / name
    link.symlink_to(target)
    assert call(*args, link).exit_code == 0
    assert link.is_symlink()
    assert target.stat().st_size > 50
    assert stat.S_IMODE(target.stat().st_mode) == 0o666 & ~umask()


def umask():
    now = os.umask(0)
    os.umask(now)
    return now


@pytest.mark.parametrize(
    ("args", "words"),
    [
        (("run", "vem", "--save", "x.csv"), ["--save 'x.csv'", ".parquet or .pq"]),
        (("run", "vem", "--record", "x.txt"), ["--record 'x.txt'", ".parquet or .pq or .csv"]),
        (("run", "vem", "--save-spec", "x.json"), ["--save-spec 'x.json'", ".toml"]),
        (("world", "make", "discs", "--out", "x.json"), ["--out 'x.json'", ".toml"]),
        (("world", "import", "room.wkt", "--out", "x.wkt"), ["--out 'x.wkt'", ".toml"]),
        (("world", "show", "wrap", "--out", "x.pdf"), ["--out 'x.pdf'", ".png or .svg"]),
        (("run", "vem", "--save", "a.parquet", "--record", "./a.parquet"), ["the same file"]),
    ],
)
def test_a_wrong_ending_or_one_name_twice_is_refused(args, words, here):
    line = refusal(*args)
    for word in words:
        assert word in line
    assert [path.name for path in here.iterdir()] == ["room.wkt"]


def test_outputs_are_looked_at_before_the_run(monkeypatch):
    monkeypatch.setattr("app.cli.run.run_ticks", None)
    for option in ("--save", "--save-spec", "--record"):
        assert "is a folder" in refusal("run", "vem", option, "/tmp")


def test_a_recording_can_be_a_sheet_of_numbers():
    made = ("run", "vem", "--ticks", 4, "--seed", 3, "--quiet", "--record")
    assert call(*made, "run.csv").exit_code == call(*made, "run.parquet").exit_code == 0
    assert pc.read_csv("run.csv").equals(pq.read_table("run.parquet").replace_schema_metadata())
    assert "is not a state" in refusal("run", "--state", "run.csv")


@folders
def test_results_are_replaced_only_when_asked(args, name, here):
    (here / "out").mkdir()
    (here / "out" / name).write_text("mine")
    assert "exists already" in refusal(*args, "--out", "out", "--quiet")
    (here / "out" / name).unlink()
    (here / "out" / name).symlink_to("/dev/null")
    for more in ((), ("--overwrite",)):
        assert "is a device" in refusal(*args, "--out", "out", "--quiet", *more)
    assert [path.name for path in (here / "out").iterdir()] == [name]


def test_results_are_made_again_when_asked():
    args = ("formation", "spacing", "--no-pictures", "--out", "out")
    assert call(*args).exit_code == 0
    assert "'out/spacing.csv' exists already" in refusal(*args)
    assert call(*args, "--overwrite").stderr == "written: out/spacing.csv\n"


def test_every_written_file_is_named_on_stderr_and_in_json():
    args = ("run", "vem", "--ticks", 1, "--observe", "groups", "--json", "--overwrite", "--save",
            "a.parquet", "--save-spec", "a.toml", "--record", "b.csv")  # fmt: skip
    result = call(*args)
    assert result.stderr.endswith("written: b.csv, a.parquet, a.toml\n")
    assert '"recording": "b.csv", "state": "a.parquet", "spec_file": "a.toml"' in result.stdout
    assert call(*args, "--quiet").stderr == ""


def test_nothing_half_written_is_left(here):
    (here / "kept.txt").write_text("old")
    with pytest.raises(ZeroDivisionError), writing("file", "kept.txt") as file:
        file.write(b"new" * (1 // 0))
    no_space = pytest.raises(InputError, match=r"'kept.txt' cannot be written: No space")
    with no_space, writing("file", "kept.txt") as file, open("/dev/full", "wb", 0) as full:
        file.write(b"new")
        full.write(b"new")
    with pytest.raises(InputError, match="no character of UTF-8"):
        write_text("file", "kept.txt", "\udcff")
    assert (here / "kept.txt").read_text() == "old"
    assert {path.name for path in here.iterdir()} == {"room.wkt", "kept.txt"}


def test_a_state_from_python_follows_the_same_rules():
    flock = Flock("vem", agents=5, rng=1)
    flock.save("flock.parquet")
    flock.save("flock.parquet")
    for place, words in (("flock.csv", "a name that ends in"), ("/dev/full", "is a device")):
        with pytest.raises(InputError, match=words):
            flock.save(place)


FULL = """
import sys
from agents.recordings.recorder import Recorder
from agents import Flock
flock = Flock("vem", agents=3000, rng=1)
with Recorder(sys.argv[1], flock) as recorder:
    while True:
        recorder.write()
        flock.tick += 1
"""


def test_a_full_disk_keeps_the_frames_that_fitted_in_the_part(here):
    """A disk of 3 MB: there is no room for the recording beside its `.part`."""
    disk = here / "disk"
    disk.mkdir()
    mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=3m", "tmpfs", disk],
                             capture_output=True)  # fmt: skip
    if mounted.returncode:
        pytest.skip("only root mounts a small disk; RLIMIT_FSIZE stands for it in test_refusals.py")
    try:
        made = subprocess.run([sys.executable, "-c", FULL, disk / "run.parquet"],
                              capture_output=True, text=True)  # fmt: skip
        last = made.stderr.strip().split("\n")[-1]
        assert "run.parquet' cannot be written: No space left on device" in last
        part = disk / "run.parquet.part"
        if part.exists():
            assert "holds" in last
            assert f"`flockscope recover {part}`" in last
            (here / part.name).write_bytes(part.read_bytes())
            part.unlink()
            assert call("recover", here / part.name).exit_code == 0
            path = here / "run.parquet"
        else:
            path = disk / "run.parquet"
        ticks = pq.read_table(path)["tick"].to_pylist()
        assert f"{max(ticks) + 1} frames that fitted, the last of tick {max(ticks)}" in last
        assert len(ticks) == 3000 * (max(ticks) + 1) > 20_000
        assert [one.name for one in disk.iterdir() if one.suffix == ".tmp"] == []
    finally:
        subprocess.run(["umount", disk], check=True)


def test_a_file_of_another_kind_named_like_the_store_is_left_as_it_is(here):
    (here / "out").mkdir()
    mine = "a,b\n1,2\nno end of line"
    (here / "out" / "runs.sqlite").write_text(mine)
    args = ("paper", "liu2021-table1", "--runs", 2, "--out", "out", "--quiet", "--no-pictures")
    assert "is not a store of runs" in refusal(*args)
    assert Path("out/runs.sqlite").read_text() == mine


def test_a_device_is_not_read_without_end(here):
    """`/dev/zero` has no end: what reads it whole takes all memory of the machine."""
    for args in (("run", "--spec"), ("live", "run"), ("live", "check"), ("live", "lab")):
        assert "'/dev/zero' cannot be read: it is a device, not a file" in refusal(
            *args, "/dev/zero"
        )
    (here / "zero.toml").symlink_to("/dev/zero")
    assert "it is a device" in refusal("run", "vem", "--world", "zero.toml")
    with open("huge.toml", "wb") as file:
        file.truncate(65 * 2**20)
    assert "it has more than 64 MiB" in refusal("run", "--spec", "huge.toml")


def test_what_is_no_recording_of_cars_is_refused_in_our_words(here):
    for name, words in (("nothing", "there is no such folder"), ("room.wkt", "it is no folder"),
                        ("empty", "the folder has no ticks.parquet")):  # fmt: skip
        (here / "empty").mkdir(exist_ok=True)
        line = refusal("live", "replay", name)
        assert line.startswith(f"flockscope: recording '{name}' cannot be read: {words}")
