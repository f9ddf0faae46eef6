"""`flockscope run --record`: what is in the file, and what is left when a run is stopped."""

import json
import signal
import subprocess

import numpy as np
import pyarrow.parquet as pq
import pytest

from agents import Flock
from agents.spec import Spec
from cli.calling import call, size, start, wait_until

LONG = ("run", "hwvem", "--agents", 300, "--seed", 5, "--set", "eta=0.2", "--ticks", 10**8)


def script_flock(ticks):
    """The flock of LONG after some ticks."""
    flock = Flock("hwvem", agents=300, rng=5, eta=0.2)
    flock.run(ticks)
    return flock


@pytest.fixture(scope="module", autouse=True)
def compiled():
    """No test here waits for the compiler in a program of its own."""
    script_flock(1)


def test_the_file_holds_ticks_ids_and_the_spec(tmp_path):
    path = tmp_path / "run.parquet"
    result = call("run", "hwvem", "--agents", 40, "--seed", 7, "--ticks", 10, "--every", 4,
                  "--record", path, "--json", "--quiet")  # fmt: skip
    assert json.loads(result.stdout)["recording"] == str(path)
    table = pq.read_table(path)
    ticks = table["tick"].to_numpy()
    assert sorted(set(ticks.tolist())) == [0, 4, 8, 10]
    flock = Flock("hwvem", agents=40, rng=7)
    for tick in (0, 4, 8, 10):
        flock.run(tick - flock.tick)
        frame = table.filter(ticks == tick)
        assert np.array_equal(frame["id"].to_numpy(), flock.ids)
        assert np.array_equal(frame["x"].to_numpy(), flock.position[:, 0])
        assert np.array_equal(frame["uy"].to_numpy(), flock.heading[:, 1])
        assert np.array_equal(frame["informed"].to_numpy(zero_copy_only=False), flock.informed)
    meta = json.loads(table.schema.metadata[b"flockscope"])
    assert Spec.from_toml(meta["spec"]) == flock.spec
    assert not path.with_name("run.parquet.part").exists()


@pytest.mark.parametrize(
    ("ticks", "ticks_there", "told"),
    [
        (
            10,
            [0, 4, 8, 10],
            "frames are 4 ticks apart, but the last, of tick 10, 2: the end of a run",
        ),
        (8, [0, 4, 8], ""),
        (3, [0, 3], "frames are 4 ticks apart, but the last, of tick 3, 3:"),
    ],
)
def test_an_end_that_is_recorded_out_of_turn_is_told(tmp_path, ticks, ticks_there, told):
    path = tmp_path / "run.parquet"
    args = ("run", "hwvem", "--agents", 40, "--seed", 7, "--ticks", ticks, "--every", 4)
    said = call(*args, "--record", path).stderr
    assert sorted(set(pq.read_table(path)["tick"].to_pylist())) == ticks_there
    assert told in said
    assert ("always recorded" in said) == bool(told)
    quiet = call(*args, "--record", path, "--overwrite", "--quiet").stderr
    assert "always recorded" not in quiet
    apart = json.loads(call("recording", path, "--json").stdout)["ticks_apart"]
    steps = np.diff(ticks_there)
    assert apart == [steps.min(), steps.max()]
    shown = call("recording", path).stdout
    assert ("2 to 4 ticks apart" in shown) == (ticks == 10)


@pytest.mark.parametrize("sent", [signal.SIGINT, signal.SIGTERM])
def test_a_stopped_run_leaves_a_recording_that_goes_on(tmp_path, sent):
    path = tmp_path / "run.parquet"
    process = start(*LONG, "--every", 5, "--record", path, "--json")
    wait_until(lambda: size(tmp_path / "run.parquet.part") > 100_000, process)
    process.send_signal(sent)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert stdout == ""
    (line,) = stderr.strip().split("\n")
    table = pq.read_table(path)
    last = int(table["tick"].to_numpy().max())
    assert f"stopped at tick {last} of {10**8}" in line
    again = f"flockscope run --ticks {10**8 - last} --every 5 --state {path} --record {tmp_path}/"
    assert again in line
    assert [file.name for file in tmp_path.iterdir()] == ["run.parquet"]
    made = json.loads(call("run", "--state", path, "--ticks", 9, "--json", "--quiet").stdout)
    assert made["tick"] == last + 9
    assert made["observables"]["polarisation"] == script_flock(last + 9).observe("polarisation")


def test_a_stopped_run_without_a_file_says_so(tmp_path):
    process = start(*LONG, "--save-spec", tmp_path / "spec.toml")
    wait_until(lambda: size(tmp_path / "spec.toml") > 0, process)
    with pytest.raises(subprocess.TimeoutExpired):
        process.communicate(timeout=1.0)
    process.send_signal(signal.SIGINT)
    stdout, stderr = process.communicate(timeout=60)
    assert process.returncode == 130
    assert stdout == ""
    assert "nothing was kept" in stderr


def test_what_a_kill_leaves_can_be_recovered(tmp_path):
    path, part = tmp_path / "run.parquet", tmp_path / "run.parquet.part"
    process = start(*LONG, "--record", path)
    wait_until(lambda: size(part) > 3_000_000, process)
    process.kill()
    process.communicate(timeout=60)
    assert not path.exists()
    again = call(*LONG, "--record", path)
    assert again.exit_code == 2
    assert f"flockscope recover {part}" in again.stderr
    result = call("recover", part, "--json")
    assert result.exit_code == 0, result.stderr
    made = json.loads(result.stdout)
    table = pq.read_table(path)
    assert made == {"recording": str(path), "rows": table.num_rows}
    assert table.num_rows % 301 == 0
    assert not part.exists()
    flock = Flock.load(path)
    assert np.array_equal(flock.position, script_flock(flock.tick).position)
