"""Pictures of the scene that a browser is asked for: only those, once, and looked at first."""

import io
import threading
from types import SimpleNamespace

import msgspec
import numpy as np
import pytest
from PIL import Image
from viser import _messages as messages

from app.front.client_addresses import RateLimit
from app.front.message_filter import BYTES, RENDER, MessageFilter
from app.front.renders import GROUND, RenderCamera, Renders
from worlds.input_error import InputError

EYE = RenderCamera(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]), 0.5)


def pictured(size, kind="png", mode="RGB", colour=(200, 30, 30)):
    """A picture as bytes."""
    made = io.BytesIO()
    Image.new(mode, size, colour).save(made, kind)
    return made.getvalue()


class Page:
    """A browser that is asked; `answer` makes what it sends of the request."""

    def __init__(self, renders, answer, number=3, there=True):
        self.renders, self.answer, self.client_id = renders, answer, number
        self.asked = []
        connected = {number: self} if there else {}
        self._viser_server = SimpleNamespace(flush=lambda: None, _connected_clients=connected)
        self._websock_connection = SimpleNamespace(queue_message=self.asked.append)

    def flush(self):
        threading.Thread(target=self.send).start()

    def send(self):
        payload, number = self.answer(self.asked[-1])
        if payload is not None:
            name = self.asked[-1].render_uuid
            self.renders.take(number, messages.GetRenderResponseMessage(payload, name))


def ask(answer, size=(80, 60), timeout=5.0, **more):
    """What is got of a browser that answers so."""
    renders = Renders()
    page = Page(renders, answer, **more)
    try:
        return renders.ask(page, size, EYE, exact=True, timeout=timeout), page.asked[0]
    finally:
        assert renders.awaited == {}


def test_a_picture_is_what_the_browser_drew():
    seen, asked = ask(lambda one: (pictured((one.width, one.height)), 3))
    assert seen.shape == (60, 80, 3)
    assert (seen == [200, 30, 30]).all()
    assert (asked.format, asked.fov, asked.position) == ("image/png", 0.5, (0.0, 0.0, 0.0))


def test_what_is_clear_has_the_page_behind_it():
    seen, _ = ask(lambda _: (pictured((80, 60), mode="RGBA", colour=(0, 0, 0, 0)), 3))
    assert (seen == GROUND).all()


@pytest.mark.parametrize(
    ("payload", "why"),
    [
        (b"", "cannot draw 80 x 60"),
        (b"no picture", "what is no picture"),
        (pictured((80, 60), "gif"), "what is no picture"),
        (pictured((80, 60))[:-30], "what is no picture"),
        (pictured((81, 60)), "another size"),
    ],
)
def test_what_is_no_such_picture_is_refused(payload, why):
    with pytest.raises(InputError, match=why):
        ask(lambda _: (payload, 3))


def test_a_browser_that_never_answers_is_not_waited_for():
    with pytest.raises(InputError, match=r"nothing in 0\.3 s"):
        ask(lambda _: (None, 3), timeout=0.3)
    with pytest.raises(InputError, match="has gone"):
        ask(lambda _: (None, 3), there=False)


def test_another_browser_cannot_answer():
    with pytest.raises(InputError, match="nothing in"):
        ask(lambda _: (pictured((80, 60)), 4), timeout=0.3)


def test_only_what_is_asked_for_comes_in_and_only_once():
    """And its bytes do not count: a film has more of them than anybody else may send."""
    allowed = []

    def answer(request):
        limits = RateLimit(1e9, 1e9), lambda _: None
        line = MessageFilter(*limits, lambda: 0.0, expected=renders.expects)
        line.introduced = True
        for name in ("unknown", request.render_uuid, request.render_uuid):
            data = msgspec.msgpack.encode(
                {"type": RENDER, "payload": b"x" * 100_000, "render_uuid": name}
            )
            line.count_message()
            line.count_bytes(len(data))
            allowed.append(line.accepts(data))
        assert line.bytes.left == pytest.approx(BYTES[1] - 200_000, abs=1000)
        return b"", 3

    renders = Renders()
    with pytest.raises(InputError, match="cannot draw"):
        renders.ask(Page(renders, answer), (80, 60), EYE, timeout=5.0)
    assert allowed == [False, True, False]
