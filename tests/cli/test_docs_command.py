"""`flockscope docs` serves the pages of a folder to this machine, and nothing else."""

from __future__ import annotations

import socket
import threading
import urllib.error
import urllib.request

import pytest
from pages.running import visit

from app.cli import docs
from app.cli.docs import open_server
from cli.calling import call


@pytest.fixture
def site(tmp_path):
    """A folder with a page, a folder without one, and a file beside it that is nobody's."""
    folder = tmp_path / "site"
    (folder / "pictures").mkdir(parents=True)
    (folder / "index.html").write_text("<html><title>flockscope</title></html>")
    (folder / "pictures" / "flock.txt").write_text("flock")
    (tmp_path / "secret.txt").write_text("secret")
    return folder


def test_it_opens_the_browser_on_the_pages_and_ends_with_ctrl_c(site, monkeypatch):
    result = visit(["docs", str(site)], monkeypatch)
    assert result.exit_code == 0
    assert result.stdout.startswith("flockscope's pages are at http://localhost:")


def test_it_answers_with_files_of_the_folder_alone(site):
    with open_server(site, 0) as server:
        thread = threading.Thread(target=server.serve_forever)
        thread.start()
        try:
            address = f"http://127.0.0.1:{server.server_port}"
            with urllib.request.urlopen(f"{address}/pictures/flock.txt") as answer:
                assert answer.read() == b"flock"
            for path in ("/pictures/", "/../secret.txt", "/%2e%2e/secret.txt", "/none.html"):
                with pytest.raises(urllib.error.HTTPError, match="404"):
                    urllib.request.urlopen(address + path)
        finally:
            server.shutdown()
            thread.join()


def test_a_port_that_is_taken_and_a_folder_without_pages_are_refused(site, tmp_path):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        result = call("docs", str(site), "--no-open", "--port", str(port))
    assert result.exit_code == 2
    assert f"port {port} on 127.0.0.1 cannot be used" in result.stderr
    result = call("docs", str(tmp_path), "--no-open")
    assert result.exit_code == 2
    assert "has no index.html" in result.stderr


def test_where_no_pages_are_installed_it_says_how_to_get_them(tmp_path, monkeypatch):
    monkeypatch.setattr(docs, "FOLDER", tmp_path)
    monkeypatch.setattr(docs, "PACKAGE", "no_pages_of_flockscope")
    result = call("docs", "--no-open")
    assert result.exit_code == 2
    assert "flockscope-docs" in result.stderr
