"""What `flockscope lab FILE` opens, and what it refuses in one line."""

import pytest

from agents import Flock
from agents.recordings.recorder import Recorder
from agents.spec import Spec
from cli.calling import refusal


@pytest.fixture(scope="module")
def files(tmp_path_factory):
    """A folder with a state, a recording, a spec, and what only looks like one of them."""
    folder = tmp_path_factory.mktemp("files")
    flock = Flock("vem", agents=20, rng=3)
    with Recorder(folder / "flight.parquet", flock) as recorder:
        for _ in range(4):
            recorder.write()
            flock.run(2)
    with Recorder(folder / "flight.csv", flock) as recorder:
        recorder.write()
    flock.save(folder / "state.parquet")
    (folder / "spec.toml").write_text(flock.spec.to_toml())
    (folder / "state.bin").write_bytes((folder / "state.parquet").read_bytes())
    (folder / "cut.parquet").write_bytes((folder / "flight.parquet").read_bytes()[:3000])
    (folder / "picture.parquet").write_bytes(b"\x89PNG\r\n\x1a\n\x00\x00\x00\rIHDR")
    (folder / "two.zip").write_bytes(b"PK\x03\x04\x14\x00")
    (folder / "other.toml").write_text('[project]\nname = "somebody"\n')
    (folder / "here.txt").write_text("hello = there\n")
    import pyarrow as pa
    import pyarrow.parquet as pq

    pq.write_table(pa.table({"tick": [1], "id": [2]}), folder / "foreign.parquet")
    return folder


@pytest.mark.parametrize(
    ("name", "says"),
    [
        ("none.parquet", "cannot be read: No such file or directory"),
        ("none", "unknown model 'none'"),
        (".", "cannot be read: Is a directory"),
        ("cut.parquet", "is not a state or a recording of flockscope"),
        ("foreign.parquet", "is not a state or a recording of flockscope"),
        ("picture.parquet", "is no file that the laboratory opens"),
        ("two.zip", "is a ZIP, as of two flocks side by side"),
        ("flight.csv", "is a recording as CSV, which has no spec"),
        ("other.toml", "unknown key 'project'"),
        ("here.txt", "is not TOML"),
    ],
)
def test_what_cannot_be_opened_is_one_line(files, monkeypatch, name, says):
    monkeypatch.chdir(files)
    line = refusal("lab", name, "--no-open")
    assert says in line
    assert name in line


def test_a_file_has_a_run_of_its_own(files):
    line = refusal("lab", files / "state.parquet", "--agents", 3, "--no-open")
    assert "has a run of its own: it cannot be given with --agents" in line


def test_files_are_told_apart_by_what_is_in_them(files):
    from app.viewer.gallery.file_opener import opened_file
    from app.viewer.gallery.saved_scene import SavedScene

    kinds = {name: opened_file(str(files / name)) for name in ("state.bin", "flight.parquet")}
    assert {name: one.kind for name, one in kinds.items()} == {
        "state.bin": "saved state",
        "flight.parquet": "recording",
    }
    assert isinstance(opened_file(str(files / "spec.toml")), SavedScene)
    assert kinds["state.bin"].spec.but(parameters={}) == Spec(
        "vem", agents=20, informed=0, seed=3, world="wrap", dim=2,
        size=float(Flock("vem", agents=20, rng=3).world.size[0]),
    )  # fmt: skip
