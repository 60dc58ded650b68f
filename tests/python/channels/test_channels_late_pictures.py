"""Pictures paced by the wall clock: late ones are skipped, and nothing waits for them."""

from collections.abc import Callable
from threading import Event
from types import SimpleNamespace

from uwsim.channels.delivery.pictures import RATE_HZ, Pictures

PERIOD_NS = int(1e9 / RATE_HZ)


class SlowCamera:
    """A camera whose pictures are ready when the test sets `may_end`; each encodes the period in which it began."""

    def __init__(self, sim: SimpleNamespace) -> None:
        self.sim = sim
        self.may_end = Event()
        self.begun: list[int] = []

    def later(self) -> Callable[[], SimpleNamespace]:
        at = self.sim.time_ns // PERIOD_NS

        def capture() -> SimpleNamespace:
            self.begun.append(at)
            assert self.may_end.wait(180)
            return SimpleNamespace(jpeg=lambda quality: str(at).encode())

        return capture


def test_a_late_picture_is_read_once_when_it_is_ready_and_none_is_begun_before() -> None:
    sim = SimpleNamespace(time_ns=0)
    camera, pictures = SlowCamera(sim), Pictures(may_wait=lambda: False)

    def read(period: int) -> bytes | None:
        sim.time_ns = period * PERIOD_NS
        picture = pictures.read(sim, "front", camera)
        return None if picture is None else picture.jpeg

    assert [read(period) for period in range(5)] == [None] * 5, "the steps do not wait"
    camera.may_end.set()
    ready = next(iter(pictures._jobs["front"])).picture
    ready.result(180)
    assert [read(5), read(5)] == [b"0", b"0"], "all readers of one period get the same"
    pictures._jobs["front"][-1].picture.result(180)
    assert read(6) == b"5"
    assert camera.begun[:2] == [0, 5]
