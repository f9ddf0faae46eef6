"""nginx and Caddy, as the page of docs configures them, before a class on this machine."""

from __future__ import annotations

import datetime
import shutil
import socket
import subprocess
from pathlib import Path
from typing import Self

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID

from tests.pages.blocks import blocks_of
from tests.viewer.waiting import until

PAGE = "docs/behind-a-proxy.md"
NAME = "class.localhost"
"""A name that browsers find on this machine, but that is not this machine's own."""
NGINX = """daemon off;
pid {folder}/nginx.pid;
error_log {folder}/errors.log;
events {{}}
http {{
    client_body_temp_path {folder}/body;
    proxy_temp_path {folder}/proxy;
    fastcgi_temp_path {folder}/fastcgi;
    uwsgi_temp_path {folder}/uwsgi;
    scgi_temp_path {folder}/scgi;
{block}
}}
"""
CADDY = """{{
    admin off
    auto_https disable_redirects
    skip_install_trust
    storage file_system {folder}/caddy
}}
{block}
"""


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as free:
        return free.getsockname()[1]


def printed(language: str, below: bool = False) -> str:
    """The configuration on the page; `below` a path, as nginx has it."""
    whole, *more = (one.code for one in blocks_of(PAGE) if one.language == language)
    if not below:
        return whole
    (location,) = more
    return f"{whole.partition('    location /')[0]}{location}}}"


def replaced(text: str, words: dict[str, str]) -> str:
    """A text with other words; each is there."""
    for old, new in words.items():
        assert old in text, old
        text = text.replace(old, new)
    return text


class RealProxy:
    """Runs before a class at `inner` until left; `kind` is nginx or caddy.

    `below`: the path below which it has the class, as the page has it.
    """

    def __init__(self, kind: str, folder: Path, port: int, inner: int, below: str = ""):
        self.kind, self.folder, self.port, self.below = kind, folder, port, below
        words = {"class.example.org": NAME, ":8080": f":{inner}"}
        program = shutil.which(kind) or kind
        if kind == "nginx":
            words |= {
                "listen 443": f"listen 127.0.0.1:{port}",
                "/etc/ssl/class.pem": str(folder / "class.pem"),
                "/etc/ssl/class.key": str(folder / "class.key"),
            }
            certify(folder)
            whole, named = NGINX, "nginx.conf"
            self.command = [program, "-p", str(folder), "-c", str(folder / named),
                            "-e", str(folder / "errors.log")]  # fmt: skip
        else:
            words["class.example.org"] = f"{NAME}:{port}"
            whole, named = CADDY, "Caddyfile"
            self.command = [program, "run", "--config", str(folder / named), "--adapter",
                            "caddyfile"]  # fmt: skip
        block = replaced(printed("nginx" if kind == "nginx" else "caddyfile", bool(below)), words)
        (folder / named).write_text(whole.format(folder=folder, block=block))
        self.log = folder / "said.log"

    def __enter__(self) -> Self:
        with self.log.open("w") as said:
            self.process = subprocess.Popen(self.command, stdout=said, stderr=said)
        try:
            until(self.answers, 30, "a proxy")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        self.process.terminate()
        try:
            self.process.wait(60)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()

    def answers(self) -> bool:
        """Whether it takes connections."""
        assert self.process.poll() is None, self.log.read_text()
        try:
            socket.create_connection(("127.0.0.1", self.port), 1).close()
        except OSError:
            return False
        return True

    @property
    def written(self) -> str:
        """All that it has written down."""
        logs = [self.log, *self.folder.glob("*.log")]
        return "".join(log.read_text(errors="replace") for log in logs)


def certify(folder: Path) -> None:
    """A certificate of the name, by nobody in particular."""
    key = ec.generate_private_key(ec.SECP256R1())
    name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, NAME)])
    now = datetime.datetime.now(datetime.UTC)
    made = (
        x509.CertificateBuilder()
        .subject_name(name)
        .issuer_name(name)
        .public_key(key.public_key())
        .serial_number(x509.random_serial_number())
        .not_valid_before(now - datetime.timedelta(days=1))
        .not_valid_after(now + datetime.timedelta(days=2))
        .add_extension(x509.SubjectAlternativeName([x509.DNSName(NAME)]), critical=False)
        .sign(key, hashes.SHA256())
    )
    (folder / "class.pem").write_bytes(made.public_bytes(serialization.Encoding.PEM))
    (folder / "class.key").write_bytes(
        key.private_bytes(
            serialization.Encoding.PEM,
            serialization.PrivateFormat.PKCS8,
            serialization.NoEncryption(),
        )
    )
