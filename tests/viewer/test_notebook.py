"""A laboratory shown from Python: where it may be framed, and what becomes of the flock."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import urllib.request
from dataclasses import replace

import numpy as np
import pytest

from app.viewer.notebook_view import (
    NotebookAccess,
    NotebookView,
    Server,
    find_place,
    open_views,
    running_servers,
    show,
)
from flockscope import Disc, Flock, world
from tests.viewer.waiting import until
from worlds.input_error import InputError

NOWHERE = NotebookAccess()


@pytest.fixture(autouse=True)
def no_notebook(monkeypatch, tmp_path):
    """Neither a hub nor a server of whoever runs the tests, and no browser."""
    monkeypatch.delenv("JUPYTERHUB_SERVICE_PREFIX", raising=False)
    monkeypatch.delenv("JPY_PARENT_PID", raising=False)
    monkeypatch.setenv("JUPYTER_RUNTIME_DIR", str(tmp_path / "runtime"))
    monkeypatch.setattr("webbrowser.open", lambda _: True)
    yield
    for one in list(open_views):
        one.end()


def server(folder, pid=None, **more):
    """Leave the file of a server, as Jupyter does."""
    said = {
        "pid": pid or os.getpid(), "port": 8888, "hostname": "localhost", "base_url": "/",
        "secure": False, "token": "x", "url": "http://localhost:8888/", "sock": "",
    }  # fmt: skip
    folder.mkdir(exist_ok=True)
    (folder / f"jpserver-{len(list(folder.iterdir()))}.json").write_text(json.dumps(said | more))


def flock() -> Flock:
    made = Flock("vem", agents=30, rng=1, eta=0.4)
    made.run(20)
    return made


def test_the_pages_of_the_server_that_has_started_it_may_frame_it(tmp_path, monkeypatch):
    assert find_place() == NOWHERE
    runtime = tmp_path / "runtime"
    server(runtime)
    server(runtime, port=9999, pid=os.getppid(), secure=True, hostname="lab7")
    (runtime / "jpserver-bad.json").write_text("{")
    server(runtime, port=7777, pid=2**22 + 1)
    assert {one.port for one in running_servers()} == {8888, 9999}
    monkeypatch.setenv("JPY_PARENT_PID", str(os.getpid()))
    assert find_place() == NotebookAccess(("http://localhost:8888", "http://127.0.0.1:8888"))
    monkeypatch.setenv("JPY_PARENT_PID", "1")
    assert len(find_place().framed_by) == 5
    assert "https://lab7:9999" in find_place().framed_by


def test_the_servers_are_those_that_jupyter_lists(tmp_path):
    from jupyter_server.serverapp import list_running_servers

    server(tmp_path / "runtime")
    server(tmp_path / "runtime", port=9999, hostname="0.0.0.0", base_url="/user/ada/")
    listed = list(list_running_servers())
    assert [one.port for one in running_servers()] == [said["port"] for said in listed]
    assert [one.base for one in running_servers()] == [said["base_url"] for said in listed]


def test_on_a_hub_it_goes_through_the_proxy(monkeypatch):
    monkeypatch.setenv("JUPYTERHUB_SERVICE_PREFIX", "/user/ada/")
    place = find_place()
    assert place == NotebookAccess(("'self'",), (), "/user/ada/proxy/")
    assert place.address(4321, "abc") == "/user/ada/proxy/4321/abc/"
    named = find_place(origin="https://hub.example.org")
    assert named.framed_by == ("'self'", "https://hub.example.org")
    assert [str(one) for one in named.allow] == ["hub.example.org"]
    assert find_place("port").proxy is None


def test_a_server_that_is_reached_from_elsewhere_passes_it_on(tmp_path, monkeypatch):
    server(tmp_path / "runtime", hostname="0.0.0.0", base_url="/lab/")
    monkeypatch.setenv("JPY_PARENT_PID", str(os.getpid()))
    assert find_place().proxy == "/lab/proxy/"
    assert find_place("port").framed_by == ("http://localhost:8888", "http://127.0.0.1:8888")


def test_numeric_addresses_of_ipv6_are_in_no_policy():
    assert Server(1, 80, "::1", "/", False).origins == (
        "http://localhost:80",
        "http://127.0.0.1:80",
    )


@pytest.mark.parametrize(
    ("words", "options"),
    [
        ("through", {"through": "air"}),
        ("no Jupyter server has started this", {"through": "proxy"}),
        ("origin = '\\*'", {"origin": "*"}),
        ("origin = 'hub.example.org'", {"origin": "hub.example.org"}),
        ("origin", {"origin": "https://hub.example.org/"}),
        ("origin", {"origin": "https://a b"}),
        ("origin", {"origin": "https://a;script-src"}),
        ("origin", {"origin": "file://x"}),
        ("origin", {"origin": "https://*.example.org"}),
        ("height", {"height": 10}),
        ("height", {"height": True}),
    ],
)
def test_what_cannot_be_is_refused(words, options):
    with pytest.raises(InputError, match=words):
        show(flock(), **options)
    assert open_views == []


def test_the_laboratory_goes_on_from_the_flock_to_the_bit_and_back(capsys):
    mine = flock()
    view = mine.show()
    assert capsys.readouterr().err == f"flockscope is at {view.address}\n"
    with urllib.request.urlopen(f"{view.address}alive") as answer:
        assert answer.status == 200
    simulation = view.laboratory.simulation
    assert simulation.ready.wait(120)
    until(lambda: simulation.state.compiling is None, 120)
    assert not simulation.state.running
    assert view.flock.tick == mine.tick == 20
    simulation.step(15).result(60)
    there = view.flock
    assert type(there) is Flock
    assert (there.tick, mine.tick) == (35, 20)
    mine.run(15)
    assert np.array_equal(there.position, mine.position)
    simulation.set("eta", 0.1).result(60)
    there = view.flock
    assert there.parameters.eta == 0.1
    simulation.step(5).result(60)
    there.run(5)
    view.close()
    assert np.array_equal(view.flock.position, there.position)
    assert view.flock.tick == 40


def test_a_reset_goes_back_to_the_flock_that_was_shown():
    view = flock().show()
    simulation = view.laboratory.simulation
    until(lambda: simulation.ready.is_set() and simulation.state.compiling is None, 120)
    simulation.step(3).result(60)
    simulation.reset().result(60)
    until(lambda: simulation.frame.tick == 20)


def test_a_flock_that_is_shown_again_closes_what_was_shown():
    mine = flock()
    first = mine.show()
    other = flock().show()
    second = mine.show()
    assert open_views == [other, second]
    assert not first.is_open
    assert repr(first) == "<Laboratory of vem, closed>"
    with pytest.raises(OSError, match="refused"):
        urllib.request.urlopen(first.address, timeout=5)
    first.close()


def test_what_the_laboratory_would_refuse_is_told_at_once():
    home = world("open", size=10.0)
    mine = Flock("vem", agents=5, world=home, rng=1)
    mine.change_world(replace(home, obstacles=(Disc(centre=(5.0, 5.0), radius=4.9),)))
    with pytest.raises(InputError, match="position of row"):
        mine.show()
    assert open_views == []


def test_each_has_an_address_that_nobody_guesses_and_html_that_frames_it():
    one = NotebookView(flock(), NotebookAccess(("http://localhost:8888",)), 500, False)
    other = NotebookView(flock(), NOWHERE, 500, False)
    assert len(one.secret) == 32
    assert one.secret != other.secret
    assert f'<iframe src="{one.address}"' in one.in_html()
    assert "height: 500px" in one.in_html()
    assert "iframe" not in other.in_html()
    assert "show(origin=...)" in other.in_html()


def test_python_ends_with_a_laboratory_open(tmp_path):
    code = "from flockscope import Flock; print(Flock('vem', agents=20, rng=1).show().address)"
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=120,
        env=os.environ | {"BROWSER": "true"}, cwd=tmp_path,
    )  # fmt: skip
    assert (ran.returncode, ran.stderr.count("\n")) == (0, 1), ran.stderr
    assert ran.stdout.startswith("http://localhost:")
