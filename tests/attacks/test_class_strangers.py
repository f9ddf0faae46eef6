"""At the door of a class, without its code: nothing is served, and nobody else is kept out."""

from __future__ import annotations

import contextlib
import socket
import zlib

import psutil
import pytest
from websockets.exceptions import InvalidStatus

from tests.attacks.knocking import ended_after, knock, request, status, upgrade
from tests.classroom.running import Person, roster, running

PATHS = (
    "/",
    "/index.html",
    "/alive",
    "/scene.json",
    "/gallery.json",
    "/open?scene=model%3Avem&sure=1",
    "/class",
    "/class/",
    "/class/mine",
    "/class/roster",
    "/class/do",
    "/class/code.svg",
    "/class/choices.json",
    "/class/results.csv",
    "/class/results.png",
    "/class/class.zip",
    "/at/1/",
    "/at/1/scene.json",
    "/favicon.ico",
    "/robots.txt",
)
ODD = (
    "//class",
    "/%63lass",
    "/%2563lass",
    "/class%2froster",
    "/class/../at/1/",
    "/./class",
    "/at/1/../../class",
    "/at/%31/",
    "/at/-1/",
    "/at/99999999999999999999/",
    "/at/0/",
    "/class;x=1",
    "/class%00",
    "/class%0d%0aX-Evil:%201",
    "/%ff%fe",
    "/..%2f..%2fetc/passwd",
    "/../../etc/passwd",
    "/\\evil.example",
    "//evil.example/class",
    "http://evil.example/class",
    "http://localhost/class",
    "http://127.0.0.1:1/class/roster",
    "?class",
    "/?x=/class",
    "/#/class",
)
METHODS = ("HEAD", "POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "PROPFIND", "CONNECT")


@pytest.fixture(scope="module")
def ours(tmp_path_factory):
    """A class that runs, for all tests of this file, with its teacher and a student in it."""
    with running(tmp_path_factory.mktemp("class")) as found:
        found.known = found.teacher()
        found.student("Ada")
        yield found


def secrets_of(ours) -> list[str]:
    """All that opens anything."""
    return [ours.code, ours.teachers_link.rpartition("/")[2], *ours.known.cookies.values()]


def tells_nothing(ours, answer: bytes) -> None:
    """An answer lets nobody in and gives nothing away."""
    assert status(answer) in (0, 400, 403, 404, 405, 414, 417, 429, 431, 501), answer[:300]
    assert b"Set-Cookie" not in answer
    assert b"Location" not in answer
    assert not any(one.encode() in answer for one in secrets_of(ours))
    assert b"Ada" not in answer
    assert b"Traceback" not in answer


def patient(ours) -> None:
    """The limit of wrong tries has filled up again for a while: the class itself still serves."""
    assert roster(ours.known)["students"]


def test_nothing_is_served_by_any_path_or_method(ours, count):
    tried = 0
    for path in (*PATHS, *ODD):
        tells_nothing(ours, knock(ours.port, request(f"GET {path} HTTP/1.1")))
        tells_nothing(ours, knock(ours.port, upgrade(path)))
        tried += 2
    for method in METHODS:
        for path in ("/", "/class", "/class/do", "/at/1/"):
            body = b"" if method in ("HEAD", "CONNECT", "TRACE") else b"{}"
            length = (f"Content-Length: {len(body)}",) if body else ()
            target = "localhost:80" if method == "CONNECT" else path
            line = f"{method} {target} HTTP/1.1"
            mark = "X-Flockscope: class"
            tells_nothing(ours, knock(ours.port, request(line, mark, *length, body=body)))
            tried += 1
    patient(ours)
    count(requests=tried)


def test_every_answer_to_a_stranger_is_sealed(ours):
    for path in ("/", "/class", f"/{ours.code}"):
        answer = ours.stranger().ask(path)
        assert answer.headers["X-Frame-Options"] == "DENY"
        assert answer.headers["Cache-Control"] == "no-store"
        assert "frame-ancestors 'none'" in answer.headers["Content-Security-Policy"]
        assert answer.headers["X-Content-Type-Options"] == "nosniff"
        assert answer.headers["Server"] == "flockscope"


def test_forged_cookies_open_nothing(ours, count):
    port, given = ours.port, ours.known.cookies[f"flockscope-teacher-{ours.port}"]
    forged = (
        {f"flockscope-teacher-{port}": "x"},
        {f"flockscope-teacher-{port}": ""},
        {f"flockscope-teacher-{port}": given[:-1]},
        {f"flockscope-teacher-{port}": given.swapcase()},
        {f"flockscope-teacher-{port}": "*"},
        {f"flockscope-student-{port}": given},
        {f"flockscope-student-{port}": ours.code},
        {"flockscope-teacher": given},
        {f"flockscope-teacher-{port + 1}": given},
        {f"flockscope-student-{port}": "1"},
        {f"flockscope-student-{port}": "a" * 4000},
    )
    for cookies in forged:
        stranger = Person(port, dict(cookies))
        for path in ("/", "/class", "/class/mine", "/at/1/"):
            assert stranger.ask(path).status in (403, 429)
        assert stranger.do("end").status in (403, 429)
        with pytest.raises(InvalidStatus):
            stranger.connect()
    count(cookies=len(forged), requests=6 * len(forged))


def test_headers_that_lie_or_are_too_many_are_refused(ours, count):
    cookie = f"Cookie: {ours.known.cookie}"  # even of the teacher's browser
    lies = (
        (403, request("GET /class HTTP/1.1", cookie, host="evil.example")),
        (400, request("GET /class HTTP/1.1", cookie, host="")),
        (403, request("GET /class HTTP/1.1", cookie, host="localhost:80@evil.example")),
        (400, request("GET /class HTTP/1.1", cookie, "Host: localhost")),
        (403, request("GET /class HTTP/1.1", cookie, "Origin: http://evil.example")),
        (403, request("GET /class HTTP/1.1", cookie, "Origin: null")),
        (403, request("GET /class HTTP/1.1", cookie, f"Origin: http://localhost:{ours.port + 1}")),
        (403, request("GET /class/roster HTTP/1.1", cookie, "Sec-Fetch-Site: same-site")),
        (403, request("GET /class/roster HTTP/1.1", cookie, "Sec-Fetch-Site: cross-site")),
        (403, upgrade("/", cookie, "Origin: http://evil.example")),
        (400, request("GET /?websocket=ws://evil.example HTTP/1.1", cookie)),
        (400, request("GET /class HTTP/1.1", cookie, "X: " + "a" * 20_000)),
        (400, request("GET /class HTTP/1.1", cookie, *[f"X-{k}: 1" for k in range(500)])),
        (400, request("GET /" + "a" * 20_000 + " HTTP/1.1", cookie)),
        (400, request("GET /class HTTP/1.1", cookie, "Transfer-Encoding: chunked, identity")),
    )
    for expected, sent in lies:
        answer = knock(ours.port, sent)
        assert status(answer) in (expected, 0 if expected == 400 else expected), (sent, answer)
        tells_nothing(ours, answer)
    forwarded = [f"{name}: 10.0.0.1" for name in ("X-Forwarded-For", "X-Real-IP", "Forwarded")]
    tells_nothing(ours, knock(ours.port, request("GET /class HTTP/1.1", *forwarded)))
    count(requests=len(lies) + 1)


def test_a_form_of_another_page_lets_nobody_in(ours, count):
    body = f"code={ours.code}&name=Eve".encode()
    sent = (f"Content-Length: {len(body)}", "Content-Type: application/x-www-form-urlencoded")
    foreign = ("http://evil.example", "null", f"http://localhost:{ours.port + 1}", "file://")
    for origin in foreign:
        line = request("POST /join HTTP/1.1", *sent, f"Origin: {origin}", body=body)
        answer = knock(ours.port, line)
        assert status(answer) == 403
        assert b"Set-Cookie" not in answer
    assert [one["name"] for one in roster(ours.known)["students"]] == ["Ada"]
    count(requests=len(foreign))


def test_what_is_sent_in_another_shape_is_refused_in_a_line(ours, count):
    at = f"localhost:{ours.port}"
    own = f"Origin: http://{at}"
    form = "application/x-www-form-urlencoded"
    shapes = (
        (form + "; charset=nonsense", b"code=x"),
        (form, b"\xff\xfe\x00"),
        (form, b"&".join(b"a%d=1" % k for k in range(1000))),
        ("multipart/form-data; boundary=x", b"--x\r\n\r\n--x--"),
        ("multipart/form-data", b"nothing"),
        ("application/json", b'{"code": 1}'),
        ("text/plain", b"code=x"),
        (form, b"code=" + b"2" * 60_000),
    )
    for kind, body in shapes:
        head = (own, f"Content-Type: {kind}", f"Content-Length: {len(body)}")
        answer = knock(ours.port, request("POST /join HTTP/1.1", *head, host=at, body=body))
        assert status(answer) in (400, 403, 413, 429), (kind, answer[:200])
        assert b"Set-Cookie" not in answer
    large = (own, f"Content-Type: {form}", "Content-Length: 9999999")
    answer = knock(ours.port, request("POST /join HTTP/1.1", *large, host=at, body=b"a" * 200_000))
    assert status(answer) in (0, 413)
    count(requests=len(shapes) + 1)


def test_a_body_that_unpacks_to_far_more_is_not_unpacked(ours, count):
    packing = zlib.compressobj(9, wbits=31)
    bomb = b"".join(packing.compress(bytes(1 << 20)) for _ in range(50)) + packing.flush()
    at = f"localhost:{ours.port}"
    head = (
        f"Origin: http://{at}",
        "Content-Type: application/x-www-form-urlencoded",
        "Content-Encoding: gzip",
        f"Content-Length: {len(bomb)}",
    )
    front = psutil.Process(ours.process.pid)
    before = front.memory_info().rss
    for _ in range(4):
        answer = knock(ours.port, request("POST /join HTTP/1.1", *head, host=at, body=bomb))
        assert status(answer) in (400, 413), answer[:200]
    assert front.memory_info().rss - before < 30e6
    count(bombs=4, unpacked_MB=4 * 50)


def test_one_address_that_guesses_is_slowed_down_and_locks_nobody_out(ours, count):
    answers = [ours.stranger().ask(f"/abcde-{k:05d}").status for k in range(120)]
    assert set(answers) == {403, 429}
    assert answers.count(429) > 30
    wrong = [ours.stranger().form("/join", code="aaaaa-aaaaa", name="x").status for _ in range(20)]
    assert 429 in wrong
    assert ours.stranger().form("/teach", key="x" * 32).status in (400, 429)
    latecomer = ours.student("Bea")  # from the same address, meanwhile
    assert latecomer.ask("/").status == 200
    assert ours.teacher().ask("/class").status == 200
    count(guesses=len(answers) + len(wrong) + 1)


def test_who_says_nothing_or_too_slowly_is_ended(ours, count):
    import threading

    at = f"localhost:{ours.port}"
    kind = "Content-Type: application/x-www-form-urlencoded"
    line = ("POST /join HTTP/1.1", f"Origin: http://{at}", "Content-Length: 5000", kind)
    form = request(*line, host=at)
    slow = {
        "silent": (b"", b""),
        "head": (b"GET / HTTP/1.1\r\nHost: localhost\r\nX-A: ", b"a"),
        "body": (form, b"a"),
    }
    took: dict[str, float] = {}
    tasks = [
        threading.Thread(target=lambda n=name, s=sent: took.update({n: ended_after(ours.port, *s)}))
        for name, sent in slow.items()
    ]
    for task in tasks:
        task.start()
    for task in tasks:
        task.join()
    assert max(took.values()) < 36.0, took
    count(lines=len(took), **{f"{name}_s": round(value, 1) for name, value in took.items()})


def test_silent_lines_without_end_keep_nobody_out(ours, count):
    lines: list[socket.socket] = []
    try:
        at = ("127.0.0.1", ours.port)
        lines.extend(socket.create_connection(at, 5.0) for _ in range(1300))  # more than allowed
        assert ours.student("Cleo").ask("/").status == 200
        assert roster(ours.known)["students"]
    finally:
        for line in lines:
            with contextlib.suppress(OSError):
                line.close()
    count(connections=1300)


def test_many_requests_in_one_go_are_answered_one_by_one(ours, count):
    one = b"GET /class HTTP/1.1\r\nHost: localhost\r\n\r\n"
    answer = knock(ours.port, one * 200)
    assert answer.count(b"HTTP/1.1 ") == 1  # the first refusal ends the line
    tells_nothing(ours, answer)
    count(requests=200)


def test_who_uses_the_same_machine_finds_no_laboratory_past_the_front(ours, count):
    processes = psutil.Process(ours.process.pid).children(recursive=True)
    ports = {
        line.laddr.port
        for one in processes
        for line in one.net_connections("tcp")
        if line.status == psutil.CONN_LISTEN
    }
    assert len(ports) >= 2  # the teacher's, and that of those who watch
    tried = 0
    for port in ports:
        for path in ("/", "/alive", "/scene.json", f"/{'0' * 32}/", f"/{ours.code}/scene.json"):
            for asked in (request(f"GET {path} HTTP/1.1"), upgrade(path)):
                answer = knock(port, asked)
                assert status(answer) == 404, answer[:300]
                tells_nothing(ours, answer)
                tried += 1
    count(requests=tried)


def test_the_process_tells_nobody_its_secrets(ours):
    told = []
    for process in (one := psutil.Process(ours.process.pid), *one.children(recursive=True)):
        with contextlib.suppress(psutil.Error):
            told += [*process.cmdline(), process.name(), *process.environ().values()]
    assert told
    assert not any(secret in text for secret in secrets_of(ours) for text in told)


def test_what_goes_wrong_is_told_in_few_lines_without_a_secret(tmp_path, count):
    with running(tmp_path) as ours:
        ours.known = ours.teacher()
        code, key = secrets_of(ours)[:2]
        for path in (f"/{code}", f"/{key}", f"/{code}/x"):
            for junk in (b"\x16\x03\x01\x02\x00", b"\r\n\r\nXX / YY\r\n\r\n", b"\x00" * 100):
                sent = request(f"GET {path} HTTP/1.1").replace(b"Connection: close\r\n", b"")
                knock(ours.port, sent + junk, timeout=1.0)
            referred = f"Referer: http://localhost:{ours.port}{path}"
            knock(ours.port, request("GET / HTTP/1.1", referred))
            knock(ours.port, upgrade("/", referred, protocol="nonsense"), timeout=1.0)
        errors = ours.stop()
    assert code not in errors
    assert key not in errors
    assert "Traceback" not in errors
    assert len(errors.splitlines()) <= 14
    count(requests=15)
