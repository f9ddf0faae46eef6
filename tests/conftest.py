"""Which tests there are, how thoroughly values are drawn, and in which order files are tested.

A test bears its folder's name as a mark (`-m "not browser"`), `quick` if it needs neither a
browser nor another process, and `exhaustive` if only `.ci/run` asks for it. Files that the marks of
README, `-m quick`, `-m exhaustive` and `-m installed` leave out are not read: to read all takes
longer than to run some.
Three processes test whole files, the dear ones first, so that none is left alone at the end: one
more than a small machine has cores, since many tests wait. Cars that are driven (`LIVE`) are all
for one of the three, from the start: they mostly wait, and share the ports of tracking systems.
In the end one process goes on with what has appointments to keep (`SERIAL`): browsers, whole
classes and a cluster. Beside a compiler, or beside each other, such tests would measure the
machine. A page of the documentation is a file by itself, and so is each Python in which the wheel
is installed.

Tests write bytecode, whatever PYTHONDONTWRITEBYTECODE says: they start hundreds of processes, and
each would compile a hundred files again; so would collecting, each time.
"""

from __future__ import annotations

import functools
import gc
import os
import sys
import time
import zlib
from pathlib import Path

import pytest
from _pytest.doctest import DoctestModule
from hypothesis import settings
from xdist.scheduler import LoadFileScheduling

os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

HERE = Path(__file__).parent
BEGUN = time.monotonic()
MINUTES = float(os.environ.get("FLOCKSCOPE_TEST_MINUTES", "inf"))
"""After which no other test begins; `.ci/run` sets it, which would be ended on a slow machine."""
PART = os.environ.get("FLOCKSCOPE_TEST_PART", "")
"""Which of several equal parts of the files is run, as `2/6` (from 0 on); empty: all of them."""
LIVE = ("tests/live", "tests/cli/test_live.py")
"""What one process runs, beside the others."""
SERIAL = (
    "tests/browser",
    "tests/classroom/test_benchmark.py",
    "tests/classroom/test_worker_killed.py",
    "tests/experiments/test_cluster.py",
    "tests/live/test_slow_browser.py",
    "tests/live/test_strange_datagrams.py",
    "tests/live/test_while_driving.py",
)
"""What is run test by test after the rest, with nothing beside it."""
EXPORTED = "tests/browser/test_export"
"""What opens pages that run by themselves, most of whose time is compiled away: not serial."""
INSTALLED = HERE / "installed"
QUICK = ("flight", "oracles", "worlds")
"""Folders of tests that are quick, beside the files of this one."""
NOT_QUICK = (
    "test_commands.py",
    "test_docs.py",
    "test_foreign_kernels.py",
    "test_glossary.py",
    "test_imports.py",
    "test_interpret.py",
    "test_mesa.py",
    "test_names.py",
    "test_page.py",
    "test_processes.py",
    "test_payload.py",
    "test_scheduling.py",
    "test_site.py",
    "test_trim.py",
)
"""Files that are not quick all the same: commands, processes, what takes all models, sources or
pages."""
EXHAUSTIVE = (
    "tests/attacks",
    "tests/browser",
    "tests/papers",
    "tests/classroom/test_benchmark.py",
    "tests/classroom/test_class.py",
    "tests/classroom/test_class_in_browser.py",
    "tests/classroom/test_class_tls.py",
    "tests/classroom/test_hand_in.py",
    "tests/classroom/test_run_queue.py",
    "tests/classroom/test_worker_killed.py",
    "tests/cli/test_film.py",
    "tests/cli/test_live.py",
    "tests/cli/test_missions.py",
    "tests/cli/test_strange_recordings.py",
    "tests/cli/test_sweep_faults.py",
    "tests/cli/test_terminal.py",
    "tests/cli/test_wrong_values.py",
    "tests/experiments/test_cluster.py",
    "tests/experiments/test_missions.py",
    "tests/experiments/test_processes.py",
    "tests/experiments/test_schemes.py",
    "tests/live/test_forged_streams.py",
    "tests/live/test_killed.py",
    "tests/live/test_slow_browser.py",
    "tests/live/test_strange_datagrams.py",
    "tests/live/test_while_driving.py",
    "tests/pages/test_pages.py",
    "tests/test_benchmarks.py",
    "tests/test_conformance.py",
    "tests/test_delay.py",
    "tests/test_engine_neighbours.py",
    "tests/test_kernel_cache.py",
    "tests/test_new_rule.py",
    "tests/test_observables_of_few.py",
    "tests/test_restart.py",
    "tests/test_solid_walls.py",
    "tests/test_site.py",
    "tests/test_wind.py",
    "tests/viewer/test_preview.py",
    "tests/viewer/test_reconnects.py",
)
"""What takes all models, a real browser, every printed command, an attack, a whole class, or
minutes: three quarters of the time of all tests. `.ci/run` runs it after the rest."""
DEFAULT = "not installed and not exhaustive"
"""The marks that `pyproject.toml` asks for."""
WHOLE_FILES = {"quick", "exhaustive", "installed"}
"""The marks that tell which files need not be read."""
SINGLE = "pytest.mark.exhaustive"
"""Stands in files of which some tests are exhaustive and others not."""
QUICK_SECONDS = 60.0
"""What all that is quick may take on two cores with nothing else to do, once it is compiled."""
BEGAN = time.monotonic()
FEW = 8
"""Examples that hypothesis draws at most for a test, if what is quick is run."""
DEAR = (
    EXPORTED,
    "tests/test_solid_walls.py",
    "tests/test_engine_neighbours.py",
    "tests/test_guarded.py",
    "tests/test_crashes.py",
    "tests/test_zones.py",
    "tests/test_vasarhelyi.py",
    "tests/test_flock_among_obstacles.py",
    "tests/test_olfati_saber.py",
    "tests/test_kernel_cache.py",
    "tests/test_new_rule.py",
    "tests/test_sums.py",
    "tests/test_benchmarks.py",
    "tests/test_cars.py",
    "tests/test_rules.py",
    "tests/flight/test_commands.py",
    "tests/papers",
    "tests/test_site.py",
    "tests/cli/test_missions.py",
    "tests/experiments/test_missions.py",
    "tests/cli/test_live.py",
    "tests/cli",
)
"""What takes longest (`--durations=20` says), first."""
LATE = ("tests/test_conformance.py", "tests/test_restart.py", "tests/pages")
"""What runs every model or every printed command: late, when other tests have compiled them."""

WINDOWS: set[Path] = set()
"""Files whose tests share a window: last, since a page that shows a flock takes half a core."""
USED = "_hypothesis_internal_use_settings"
"""Where hypothesis keeps the settings of a test."""

settings.register_profile("dev", deadline=None, max_examples=25)
settings.register_profile("ci", deadline=None, max_examples=50, print_blob=True)
settings.load_profile("ci" if os.environ.get("CI") else "dev")


def is_serial(file: str) -> bool:
    """Whether a file is run when the rest has ended."""
    return file.startswith(SERIAL) and not file.startswith(EXPORTED)


class FilesThenSerial(LoadFileScheduling):
    """Hands out whole files; `SERIAL` to the process that is left when the others have ended."""

    def _split_scope(self, nodeid):
        file = super()._split_scope(nodeid)
        if file.startswith("tests/pages"):
            return nodeid
        if file.startswith("tests/installed"):
            return "installed in 3.13" if "[3.13]" in nodeid else "installed"
        if is_serial(file):
            return "serial"
        return "live" if file.startswith(LIVE) else file

    def _assign_work_unit(self, node):
        if "serial" in self.workqueue:
            self.workqueue.move_to_end("serial")
        if next(iter(self.workqueue)) != "serial" or len(self.nodes) == 1:
            super()._assign_work_unit(node)
        elif not all(other.shutting_down for other in self.nodes if other is not node):
            node.shutdown()  # after the tests that it has: another one goes on
        # Else the others are at their last tests: `remove_node` asks again when they have ended.

    def remove_node(self, node):
        crashed = super().remove_node(node)
        if self.workqueue:
            for other in self.nodes:
                self._reschedule(other)
        return crashed


@pytest.fixture(autouse=True)
def catalogue_as_it_was():
    """Models that a test brings, or first asks for, are gone after it."""
    catalogue = sys.modules.get("agents.catalogue")
    models = {} if catalogue is None else catalogue.MODELS
    before = dict(models)
    yield
    for name in models.keys() - before:
        del models[name]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config, log):
    """Hand out tests so."""
    return FilesThenSerial(config, log)


@functools.cache
def is_exhaustive(path: Path) -> bool:
    """Whether only `.ci/run` asks for a file of tests."""
    inside = path.relative_to(HERE.parent).as_posix() if path.is_relative_to(HERE) else ""
    return inside.startswith(EXHAUSTIVE)


@functools.cache
def is_quick(path: Path) -> bool:
    """Whether a file or folder of tests is, or may hold, what `-m quick` runs."""
    if not path.is_relative_to(HERE):
        return not path.is_relative_to(HERE.parent / "app")
    if path.name in NOT_QUICK or is_exhaustive(path):
        return False
    inside = path.relative_to(HERE).parts
    return not inside or inside[0] in QUICK or (len(inside) == 1 and not path.is_dir())


def names_files(config) -> bool:
    """Whether files are named on the command line."""
    told = getattr(config, "workerinput", None)
    if told is not None:
        return told["names_files"]
    return config.args_source == pytest.Config.ArgsSource.ARGS


@pytest.hookimpl(optionalhook=True)
def pytest_configure_node(node):
    """Tell a process of xdist, whose own arguments always name files."""
    node.workerinput["names_files"] = names_files(node.config)


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """Look for no garbage while tests are read, nor among what was read while they run.

    Reading makes millions of objects that stay: to go through them again and again took a quarter
    of the time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


class CollectionFilter:
    """Keeps files from being read in vain, in `app` too: pytest asks a conftest about its own
    folder only."""

    def pytest_ignore_collect(self, collection_path, config):
        """Do not even read what the marks would leave out."""
        return is_left_out(collection_path, config.option.markexpr) or None

    @pytest.hookimpl(wrapper=True)
    def pytest_collect_file(self, file_path):
        """Look for examples only in files that have some: to look, a file is imported."""
        found = yield
        if file_path.suffix == ".py" and ">>>" not in file_path.read_text(encoding="utf-8"):
            return [item for item in found if not isinstance(item, DoctestModule)]
        return found


def pytest_configure(config):
    """Leave nothing out of files that are named on the command line."""
    config.pluginmanager.register(CollectionFilter(), "collection filter")
    if config.option.markexpr == DEFAULT and names_files(config):
        config.option.markexpr = "not installed"


def is_left_out(path: Path, marks: str) -> bool:
    """Whether no test of a file or folder can bear the marks that are asked for."""
    if marks == DEFAULT:
        return path.is_relative_to(INSTALLED) or is_exhaustive(path)
    wanted = marks.split(" or ")
    return set(wanted) <= WHOLE_FILES and not any(may_hold(path, mark) for mark in wanted)


@functools.cache
def may_hold(path: Path, mark: str) -> bool:
    """Whether a file or folder is, or may hold, tests with one of the marks of WHOLE_FILES."""
    if mark == "quick":
        return is_quick(path)
    if path.is_dir():
        return True
    if mark == "installed":
        return path.is_relative_to(INSTALLED)
    return is_exhaustive(path) or (path.is_relative_to(HERE) and SINGLE in path.read_text("utf-8"))


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(config, items):
    """Mark tests by their folder, put the dear files first, and draw few examples if quick."""
    if PART:
        others = [item for item in items if not is_in_part(item.nodeid)]
        items[:] = [item for item in items if is_in_part(item.nodeid)]
        config.hook.pytest_deselected(items=others)
    for item in items:
        for mark in marks(item.path):
            if mark != "quick" or item.get_closest_marker("long") is None:
                item.add_marker(mark)
        if "shared_window" in getattr(item, "fixturenames", ()):
            WINDOWS.add(item.path)
        if config.option.markexpr == "quick":
            draw_few(getattr(item, "obj", None), USED)
            draw_few(getattr(item, "cls", None), "settings")
    items.sort(key=lambda item: (place(item.nodeid.partition("::")[0]), item.path in WINDOWS))


def is_in_part(test: str) -> bool:
    """Whether a test's file is in the part that is run; a page of the documentation is a file."""
    part, parts = map(int, PART.split("/"))
    file = test if test.startswith("tests/pages") else test.partition("::")[0]
    return zlib.crc32(file.encode()) % parts == part


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup():
    """Begin no test once the minutes are over that there are: what is left out is told."""
    if time.monotonic() - BEGUN > MINUTES * 60.0:
        pytest.skip(f"left to a quicker machine: {MINUTES:g} minutes are over")


def pytest_terminal_summary(terminalreporter, config):
    """Say if `-m quick` was not."""
    took = time.monotonic() - BEGAN
    if config.option.markexpr == "quick" and took > QUICK_SECONDS:
        load, cores = os.getloadavg()[1], os.cpu_count()
        terminalreporter.write_line(
            f"quick took {took:.0f} s, {QUICK_SECONDS:.0f} are wanted; of the last five minutes "
            f"the load was {load:.1f} on {cores} cores"
        )


def draw_few(test, where):
    """Draw at most FEW examples for a test of hypothesis, or a class of one, whatever it asks."""
    asked = getattr(test, where, None)
    if isinstance(asked, settings) and asked.max_examples > FEW:
        setattr(test, where, settings(asked, max_examples=FEW))


@functools.cache
def marks(path: Path) -> list[str]:
    """The marks that all tests of a file bear."""
    inside = path.is_relative_to(HERE) and path.parent != HERE
    folder = [path.relative_to(HERE).parts[0]] if inside else []
    return [*folder, *["quick"] * is_quick(path), *["exhaustive"] * is_exhaustive(path)]


@functools.cache
def place(file: str) -> int:
    """Where a file stands: live and first, among the dear ones, late, or serial and last."""
    if is_serial(file):
        return len(DEAR) + 2
    if file.startswith(LIVE):
        return -1
    found = (at for at, name in enumerate(DEAR) if file.startswith(name))
    return next(found, len(DEAR) + file.startswith(LATE))
