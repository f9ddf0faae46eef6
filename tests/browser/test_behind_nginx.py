"""A class behind nginx, configured as docs say: encrypted there, plain on the loopback."""

from __future__ import annotations

import json
import re
import shutil
import socket
import subprocess
import threading
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.attacks.knocking import knock, request, status
from tests.browser.conftest import absent
from tests.classroom.certificates import certified
from tests.classroom.encrypted import Encrypted
from tests.classroom.running import BUSY, roster, running
from tests.viewer.waiting import until

NAME = "class.localhost"
PAGE = Path(__file__).parents[2] / "docs" / "behind-a-proxy.md"
NGINX = shutil.which("nginx") or shutil.which("/usr/sbin/nginx")


@pytest.fixture(scope="module")
def nginx():
    """The program."""
    if NGINX is None:
        absent("nginx")
    return NGINX


def free_port() -> int:
    """A port that nobody uses."""
    with socket.create_server(("127.0.0.1", 0)) as line:
        return line.getsockname()[1]


def printed() -> str:
    """The configuration that the documentation prints."""
    return re.search(r"```nginx\n(.*?)```", PAGE.read_text(), re.DOTALL)[1]


def configured(folder: Path, port: int, inner: int, certificate: Path, key: Path) -> str:
    """That configuration with ports, a name and a certificate of this machine."""
    ours = {
        "listen 443 ssl": f"listen 127.0.0.1:{port} ssl",
        "server_name class.example.org": f"server_name {NAME}",
        "/etc/ssl/class.example.org.pem": str(certificate),
        "/etc/ssl/class.example.org.key": str(key),
        "http://127.0.0.1:8080": f"http://127.0.0.1:{inner}",
    }
    text = printed()
    for before, after in ours.items():
        assert text.count(before) == 1, before
        text = text.replace(before, after)
    kinds = ("client_body", "proxy", "fastcgi", "uwsgi", "scgi")
    places = "".join(f"{kind}_temp_path {folder}/{kind};\n" for kind in kinds)
    whole = f"pid {folder}/nginx.pid;\nerror_log {folder}/error.log;\ndaemon off;\n"
    return f"{whole}events {{}}\nhttp {{\n{places}{text}}}\n"


@contextmanager
def proxied(nginx: str, folder: Path, port: int, inner: int):
    """nginx before a class; the certificate that it shows."""
    certificate, key = certified(folder, NAME)
    folder.chmod(0o755)
    (folder / "nginx.conf").write_text(configured(folder, port, inner, certificate, key))
    command = [nginx, "-p", str(folder), "-e", str(folder / "error.log")]
    process = subprocess.Popen([*command, "-c", str(folder / "nginx.conf")])
    try:
        until(lambda: process.poll() is not None or listens(port), BUSY)
        assert process.poll() is None, (folder / "error.log").read_text()
        yield certificate
    finally:
        process.terminate()
        process.wait(BUSY)


def listens(port: int) -> bool:
    """Whether somebody takes connections there."""
    try:
        socket.create_connection(("127.0.0.1", port), 1.0).close()
    except OSError:
        return False
    return True


def test_a_class_works_behind_nginx(nginx, tmp_path):
    port = free_port()
    with running(tmp_path, "--allow-host", f"{NAME}:{port}") as ours:
        assert ours.link == f"https://{NAME}:{port}/{ours.code}"
        proxy = tmp_path / "nginx"
        proxy.mkdir()
        with proxied(nginx, proxy, port, ours.port) as certificate:
            ada = Encrypted(NAME, port, certificate)
            assert (got := ada.ask("/"))[0] == 403, got[2]
            assert ada.ask(f"/{ours.code}")[0] == 200
            cookie = ada.join(ours.code, "Ada")["Set-Cookie"]
            assert "Secure" in cookie
            status, headers, page = ada.ask("/")
            assert status == 200
            assert len(page) > 100_000
            assert f"wss://{NAME}:{port}" in headers["Content-Security-Policy"]
            with ada.connect() as line:
                for _ in range(20):
                    assert line.recv(timeout=BUSY)
            streamed(ours, ada)
            shared(ours, certificate, port)
        assert ours.code not in (proxy / "error.log").read_text()


def streamed(ours, ada: Encrypted) -> None:
    """What the teacher says is told over the stream while it goes on."""
    teacher = ours.teacher()
    timer = threading.Timer(1.0, lambda: teacher.do("say", word="look up"))
    timer.start()
    words = [json.loads(one)["word"] for one in ada.listen("/class/mine", 2)]
    timer.join()
    assert words[0] == ""
    assert words[-1] == "look up"


def shared(ours, certificate: Path, port: int) -> None:
    """All come from one address; one who guesses keeps nobody out."""
    bad = Encrypted(NAME, port, certificate)
    guesses = [
        bad.ask(f"/abcde-{k:05d}", **{"X-Forwarded-For": f"10.0.0.{k}"})[0] for k in range(100)
    ]
    assert 429 in guesses
    for k in range(40):
        if k != 1:
            Encrypted(NAME, port, certificate).join(ours.code, f"Student {k}")
    assert len(roster(ours.teacher())["students"]) == 40
    plain = knock(ours.port, request("GET / HTTP/1.1", host="class.example.org"))
    assert status(plain) == 403
