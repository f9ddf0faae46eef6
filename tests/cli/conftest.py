"""What several tests of the command line begin with."""

import pyarrow.parquet as pq
import pytest

from agents.flock import Flock
from agents.recordings.recorder import Recorder


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """A recording of three ticks of five agents."""
    path = tmp_path_factory.mktemp("sound") / "run.parquet"
    flock = Flock("vem", agents=5, rng=1)
    with Recorder(path, flock) as recorder:
        for _ in range(3):
            recorder.write()
            flock.run(1)
    return pq.read_table(path)
