"""Child processes: asked, timed, cancelled, ended, restarted; gone when their parent is."""

from __future__ import annotations

import asyncio
import os
import resource
import signal
import subprocess
import sys
import threading
from concurrent.futures import CancelledError
from multiprocessing import forkserver
from pathlib import Path

import pytest

from app.process_worker import ProcessLimits
from app.processes import ChildError, ChildProcess, ProcessLostError, ProcessTimeoutError
from tests.child_worker import Worker
from tests.viewer.waiting import until
from worlds.input_error import InputError, InputErrors

BUSY = 60.0
"""Seconds that anything may take on a busy machine."""
PRELOADS = pytest.mark.parametrize("preload", [(), (Worker.__module__,)], ids=["spawned", "forked"])


@pytest.fixture(scope="module", autouse=True)
def another_forkserver():
    """A process has one only, and others need one that has imported what theirs call."""
    forkserver._forkserver._stop()
    yield
    forkserver._forkserver._stop()


@pytest.fixture
def begin():
    """Makes child processes, and ends them."""
    made = []

    def make(*arguments, **options):
        folder = options.pop("folder", None)
        made.append(ChildProcess(Worker, *(arguments or ("",)), folder, **options))
        return made[-1]

    yield make
    for child in made:
        child.end(0.0)
        assert child.pid is None


def wait_begun(folder, name):
    assert until(lambda: (folder / f"{name} begun").exists(), BUSY)


@PRELOADS
def test_a_worker_answers_in_order_from_another_process(begin, preload):
    child = begin(preload=preload)
    replies = [child.ask("echo", number, "x" * 200_000) for number in range(3)]
    assert [one.result(BUSY)[0] for one in replies] == [0, 1, 2]
    assert child.ask("count").result(BUSY) == 3
    assert child.ask("process").result(BUSY) == child.pid != os.getpid()


def test_an_event_loop_waits_for_a_reply(begin):
    async def asked():
        child = begin()
        return await asyncio.gather(*(asyncio.wrap_future(child.ask("echo", k)) for k in range(3)))

    assert asyncio.run(asked()) == [(0,), (1,), (2,)]


def test_what_the_worker_refuses_is_raised_as_it_is_and_other_errors_become_one_line(begin):
    child = begin()
    with pytest.raises(InputErrors) as refused:
        child.ask("refuse").result(BUSY)
    assert refused.value.lines == ("one thing", "another")
    with pytest.raises(ChildError, match=r"^KeyError: 'a name\\nof two lines'$"):
        child.ask("crash").result(BUSY)
    with pytest.raises(ChildError, match=r"^TypeError: cannot pickle '_thread.lock' object$"):
        child.ask("unreadable").result(BUSY)
    with pytest.raises(AttributeError, match="nothing of this name"):
        child.ask("nothing of this name")
    assert child.ask("echo", 1).result(BUSY) == (1,), "it goes on"


def test_what_cannot_be_sent_is_the_callers_error(begin):
    child = begin()
    with pytest.raises(TypeError):
        child.ask("echo", threading.Lock())
    assert child.ask("echo", 1).result(BUSY) == (1,)


def test_values_that_a_method_yields_come_one_by_one(begin):
    parts = []
    assert begin().ask("parts", 4, receive=parts.append).result(BUSY) is None
    assert parts == [0, 1, 2, 3]


@PRELOADS
def test_a_worker_that_cannot_begin_says_why_in_one_line(begin, preload):
    ended = threading.Event()
    child = begin("refuse", preload=preload, ended=ended.set)
    with pytest.raises(ProcessLostError, match=r"begin: InputError: this worker cannot begin$"):
        child.ask("echo").result(BUSY)
    assert ended.wait(BUSY)
    assert (child.is_gone, child.exit_code) == (True, 1)


@PRELOADS
@pytest.mark.parametrize(("how", "text"), [("die", "code 7"), ("leave", "code [15]")])
def test_a_death_is_noticed_and_told_to_all_who_wait(begin, preload, how, text):
    ended = threading.Event()
    child = begin(preload=preload, ended=ended.set, stderr=subprocess.DEVNULL)
    for future in [child.ask(how), child.ask("echo")]:
        with pytest.raises(ProcessLostError, match=f"^the process ended with {text}$"):
            future.result(BUSY)
    assert ended.wait(BUSY)
    with pytest.raises(ProcessLostError):
        child.ask("echo").result(BUSY)


@PRELOADS
def test_a_process_that_is_killed_while_it_has_nothing_to_do_is_noticed(begin, preload):
    ended = threading.Event()
    child = begin(preload=preload, ended=ended.set)
    os.kill(child.ask("process").result(BUSY), signal.SIGTERM)
    assert ended.wait(BUSY)
    with pytest.raises(ProcessLostError, match=r"^the process ended with signal SIGTERM$"):
        child.ask("echo").result(BUSY)


def test_time_is_counted_from_the_start_of_the_work_not_from_the_queue(begin, tmp_path):
    child = begin(folder=tmp_path)
    first = child.ask("wait_for", "first")
    second = child.ask("wait_for", "second", timeout=2.0)
    wait_begun(tmp_path, "first")
    late = child.ask("wait_for", "nothing", timeout=0.5)
    with pytest.raises(ProcessTimeoutError, match=r"^it took longer than 0\.5 s$"):
        late.result(BUSY)  # the process is not replaced: what it is at may last for ever
    assert child.ask("echo", timeout=BUSY).cancel()
    assert not second.done()
    (tmp_path / "second").touch()
    (tmp_path / "first").touch()
    assert (first.result(BUSY), second.result(BUSY)) == ("first", "second")


def test_a_process_that_is_replaced_ends_with_the_request_that_is_late(begin, tmp_path):
    child = begin(folder=tmp_path, restarts=True)
    first = child.ask("process").result(BUSY)
    endless = child.ask("wait_for", "nothing", timeout=0.5)
    waiting = [child.ask("process", timeout=BUSY) for _ in range(3)]
    with pytest.raises(ProcessTimeoutError, match=r"^it took longer than 0\.5 s$"):
        endless.result(BUSY)
    later = {one.result(BUSY) for one in waiting}
    assert len(later) == 1
    assert first not in later


def test_a_death_costs_the_request_that_it_was_at_alone_and_first_is_done_again(begin, tmp_path):
    ended = []
    child = begin(folder=tmp_path, restarts=True, ended=lambda: ended.append(child.exit_code))
    child.first = ("write", "prepared")
    assert child.ask("echo", 1).result(BUSY) == (1,)
    (tmp_path / "prepared").unlink()
    killed, other = child.ask("die"), child.ask("echo", 2)
    with pytest.raises(ProcessLostError, match="code 7"):
        killed.result(BUSY)
    assert other.result(BUSY) == (2,)
    assert (tmp_path / "prepared").exists()
    child.kill()
    assert until(lambda: ended == [7, -signal.SIGKILL], BUSY)
    assert child.ask("echo", 3).result(BUSY) == (3,)


def test_the_least_rank_is_next_and_who_waits_no_more_is_left_out(begin, tmp_path):
    child = begin(folder=tmp_path)
    order = []
    first = child.ask("wait_for", "go", rank=9.0)
    wait_begun(tmp_path, "go")
    waiting = {rank: child.ask("echo", rank, rank=rank) for rank in (3.0, 2.0, 7.0, 1.0)}
    for rank, future in waiting.items():
        future.add_done_callback(lambda _, rank=rank: order.append(rank))
    assert waiting[1.0].cancel()
    assert not first.cancel(), "it is at it"
    (tmp_path / "go").touch()
    assert [waiting[rank].result(BUSY) for rank in (2.0, 3.0, 7.0)] == [(2.0,), (3.0,), (7.0,)]
    assert order == [1.0, 2.0, 3.0, 7.0]
    assert child.ask("count").result(BUSY) == 3
    with pytest.raises(CancelledError):
        waiting[1.0].result()


@PRELOADS
def test_an_end_waits_for_all_that_was_asked_or_kills(begin, tmp_path, preload):
    child = begin(folder=tmp_path, preload=preload)
    working, waiting = child.ask("wait_for", "done"), child.ask("echo")
    wait_begun(tmp_path, "done")
    threading.Timer(0.2, (tmp_path / "done").touch).start()
    child.end(None)
    assert (working.result(BUSY), waiting.result(BUSY)) == ("done", ())
    assert (child.pid, child.exit_code) == (None, 0)
    child = begin(folder=tmp_path, preload=preload)
    working, waiting = child.ask("wait_for", "never"), child.ask("echo")
    wait_begun(tmp_path, "never")
    child.end(0.1)
    assert child.exit_code == -signal.SIGKILL
    for future in (working, waiting, child.ask("echo")):
        with pytest.raises(ProcessLostError, match=r"^the process was ended$"):
            future.result(BUSY)


def test_one_that_is_ended_as_it_begins_or_before_is_gone(begin):
    child = begin()
    child.end()
    assert child.exit_code is None
    child = begin().start()
    child.end(0.0)
    assert child.pid is None


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no address space")
def test_memory_is_limited_and_the_process_goes_on(begin):
    child = begin(limits=ProcessLimits(memory=2 << 30))
    with pytest.raises(ChildError, match=r"^MemoryError"):
        child.ask("take", 3 << 30).result(BUSY)
    assert child.ask("take", 1 << 20).result(BUSY) == 1 << 20


@pytest.mark.skipif(sys.platform == "win32", reason="Windows limits no processor time")
def test_processor_time_is_a_timeout(begin):
    child = begin(restarts=True)
    with pytest.raises(ProcessTimeoutError, match="more processor time than it may"):
        child.ask("burn").result(BUSY)
    assert child.ask("echo").result(BUSY) == ()


def test_where_the_system_has_no_process_left_the_next_request_tries_again(begin, monkeypatch):
    def none_left():
        raise BlockingIOError(11, "Resource temporarily unavailable")

    child = begin(restarts=True)
    with monkeypatch.context() as changed:
        changed.setattr(child, "begin", none_left)
        with pytest.raises(
            ProcessLostError, match=r"cannot begin: BlockingIOError: .* unavailable$"
        ):
            child.start().ask("echo").result(BUSY)
    assert child.ask("echo").result(BUSY) == ()


def test_one_that_does_not_begin_in_time_is_told_so(begin, tmp_path):
    child = begin(folder=tmp_path, restarts=True, limits=ProcessLimits(start=0.5))
    child.first = ("wait_for", "nothing")
    with pytest.raises(ProcessTimeoutError, match=r"^the process has not begun within 0\.5 s$"):
        child.ask("echo").result(BUSY)
    child.first = ()
    child.limits = ProcessLimits()
    assert child.ask("echo").result(BUSY) == ()


def test_one_that_is_asked_for_nothing_ends_by_itself(begin):
    ended = threading.Event()
    child = begin(limits=ProcessLimits(idle=0.1), ended=ended.set).start()
    assert ended.wait(BUSY)
    assert child.exit_code == 0


def test_nothing_of_a_child_that_is_not_trusted_is_unpickled(begin, monkeypatch):
    child = begin(is_trusted=False)

    def unpickle(_):
        raise AssertionError("unpickled")

    monkeypatch.setattr("app.processes.pickle.loads", unpickle)
    assert child.ask("content", b"abc").result(BUSY) == b"cba"
    with pytest.raises(InputError, match=r"^one thing \(and 1 more\)$"):
        child.ask("refuse").result(BUSY)
    with pytest.raises(ChildError, match=r"^KeyError"):
        child.ask("crash").result(BUSY)


PARENT = """
import sys, time
from pathlib import Path
from app.processes import ChildProcess
from tests.child_worker import Worker
preload = (Worker.__module__,) if sys.argv[2] == "forked" else ()
child = ChildProcess(Worker, "", Path(sys.argv[1]), preload=preload)
print(child.ask("process").result(), flush=True)
child.ask("wait_for", "nothing")
time.sleep(1000)
"""


@pytest.mark.parametrize("start", ["spawned", "forked"])
@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM, signal.SIGINT])
def test_a_child_at_work_is_gone_when_its_parent_is(tmp_path, number, start):
    parent = subprocess.Popen(
        [sys.executable, "-c", PARENT, str(tmp_path), start],
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    child = int(parent.stdout.readline())
    wait_begun(tmp_path, "nothing")
    parent.send_signal(number)
    parent.wait(BUSY)
    parent.stdout.close()
    assert until(lambda: is_gone(child), BUSY)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no groups of processes")
def test_a_ctrl_c_for_the_whole_group_is_left_to_the_parent(begin, tmp_path):
    child = begin(folder=tmp_path)
    future = child.ask("wait_for", "done")
    wait_begun(tmp_path, "done")
    os.kill(child.pid, signal.SIGINT)
    (tmp_path / "done").touch()
    assert future.result(BUSY) == "done"


def is_gone(process: int) -> bool:
    """Whether there is no such process; one that is dead and that nobody buries is none."""
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return True
    listed = Path(f"/proc/{process}/stat")
    return listed.exists() and ") Z " in listed.read_text()


def test_a_system_that_lets_nobody_set_a_limit_has_none(monkeypatch):
    """As macOS for memory: what cannot be limited runs all the same."""
    asked = []

    def refuse(kind, limits):
        asked.append((kind, limits))
        raise ValueError("current limit exceeds maximum limit")

    monkeypatch.setattr(resource, "setrlimit", refuse)
    ProcessLimits(memory=1 << 40, processor_time=10_000).apply()
    assert [kind for kind, _ in asked] == [resource.RLIMIT_AS, resource.RLIMIT_CPU]
