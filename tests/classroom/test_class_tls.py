"""A class that encrypts by itself, with a certificate and its key."""

from __future__ import annotations

import json
import subprocess
import sys

import pytest

from tests.attacks.knocking import knock, request, upgrade
from tests.classroom.certificates import certified
from tests.classroom.encrypted import Encrypted
from tests.classroom.running import BUSY, SCENE, running


def test_a_class_with_a_certificate_is_served_encrypted_alone(tmp_path):
    certificate, key = certified(tmp_path)
    given = ("--certificate", str(certificate), "--key", str(key))
    with running(tmp_path, *given) as ours:
        assert ours.link.startswith("https://")
        assert ours.teachers_link.startswith("https://")
        ada = Encrypted("localhost", ours.port, certificate)
        status, headers, text = ada.ask(f"/{ours.code}")
        assert status == 200
        assert 'name="name"' in text
        cookie = ada.join(ours.code, "Ada")["Set-Cookie"]
        for word in ("Secure", "HttpOnly", "SameSite=Strict"):
            assert word in cookie
        status, headers, text = ada.ask("/")
        assert status == 200
        assert f"wss://localhost:{ours.port}" in headers["Content-Security-Policy"]
        assert "ws://localhost" not in headers["Content-Security-Policy"].replace("wss:", "")
        assert json.loads(ada.listen("/class/mine", 1)[0])["name"] == "Ada"
        with ada.connect() as line:
            assert line.recv(timeout=BUSY)
        for sent in (request(f"GET /{ours.code} HTTP/1.1"), upgrade("/"), b"\x16\x03\x01\x00"):
            answer = knock(ours.port, sent, timeout=15.0)
            assert b"HTTP" not in answer
            assert ours.code.encode() not in answer
        errors = ours.stop()
        assert "Traceback" not in errors
        assert ours.code not in errors


@pytest.mark.parametrize("how", ["anothers", "encrypted", "no key", "no certificate", "folder"])
def test_a_certificate_that_cannot_be_used_is_one_line(tmp_path, how):
    certificate, key = certified(tmp_path)
    if how == "anothers":
        key = certified(tmp_path, "elsewhere")[1]
    elif how == "encrypted":
        certificate, key = certified(tmp_path, word=b"a word")
    elif how == "no key":
        key.write_text("no key\n")
    elif how == "no certificate":
        certificate.write_bytes(b"\xff\x00")
    else:
        key = tmp_path
    (tmp_path / "scene.toml").write_text(SCENE)
    given = ["--certificate", str(certificate), "--key", str(key), "--port", "0", "--no-open"]
    command = [sys.executable, "-P", "-m", "flockscope", "class", "scene.toml", *given]
    made = subprocess.run(
        command,
        cwd=tmp_path,
        capture_output=True,
        text=True,
        stdin=subprocess.DEVNULL,
        start_new_session=True,
        timeout=BUSY,
    )
    assert made.returncode == 2
    assert made.stdout == ""
    (line,) = made.stderr.splitlines()
    assert line.startswith(
        f"flockscope: --certificate {str(certificate)!r} with --key {str(key)!r}"
    )
