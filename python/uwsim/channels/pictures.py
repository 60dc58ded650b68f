"""Pictures of cameras and imaging sonars; each is rendered once for all clients, in parallel with the steps."""

from __future__ import annotations

import io
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np
from numpy.typing import NDArray

from uwsim.instruments.cameras import Camera, Frame
from uwsim.simulator.simulator import Simulator

T = TypeVar("T")
RATE_HZ = 10.0
WIDTHS = (16, 4096)


@dataclass(frozen=True)
class Stream:
    """Settings of a camera stream; see the service camera/NAME/set_stream. width: 0 for the original size.

    Raises ValueError.
    """

    enabled: bool = True
    rate_hz: float = RATE_HZ
    width: int = 0
    quality: int = 80

    def __post_init__(self) -> None:
        rules = {
            "rate_hz": (0.01 <= self.rate_hz <= RATE_HZ, f"must be in [0.01, {RATE_HZ:g}]"),
            "width": (self.width == 0 or WIDTHS[0] <= self.width <= WIDTHS[1], f"must be 0 or in {list(WIDTHS)}"),
            "quality": (1 <= self.quality <= 100, "must be in [1, 100]"),
        }
        for name, (holds, rule) in rules.items():
            if not holds:
                raise ValueError(f"{name} = {getattr(self, name)}: {rule}")

    def is_due(self, slot: int) -> bool:
        """Return whether a picture is sent in the period with this index; periods are 1 / RATE_HZ long."""
        share = self.rate_hz / RATE_HZ
        return self.enabled and int(slot * share + 1e-6) != int((slot - 1) * share + 1e-6)


class Picture(NamedTuple):
    """A frame, its JPEG, and the stream settings at that time."""

    frame: Frame
    jpeg: bytes
    stream: Stream


Begin = Callable[[Stream], Callable[[], Any]]
"""Stores the current state, on the stepping thread; returns a function that renders it on another thread."""


@dataclass(eq=False)
class _Job:
    slot: int
    picture: Future[Any]
    is_first: bool
    read_in: int | None = None  # the period in which it was read


class Pictures:
    """The last two pictures of each camera or imaging sonar, and its stream settings.

    Simulated time is divided into periods of 1 / RATE_HZ. The first reading in a period starts rendering the scene as
    it is at that time, on a separate thread. If the steps may wait, the next reading in a later period waits for the
    picture and returns it, so results do not depend on how long rendering takes. If not, readings return the picture in
    the first period in which it is ready, and no other picture is started until then, so pictures are skipped if the
    machine is too slow. After a pause in reading, earlier pictures are dropped, so that a new subscriber receives none
    of them.

    may_wait: called at each reading; returns whether the steps may wait.
    """

    def __init__(self, may_wait: Callable[[], bool] = lambda: True) -> None:
        self._may_wait = may_wait
        self._streams: dict[str, Stream] = {}
        self._jobs: dict[str, list[_Job]] = {}
        self._last: dict[str, tuple[int, int]] = {}  # period of each camera's last reading, and its gap to the previous
        self._worker = ThreadPoolExecutor(1, "uwsim-pictures")

    @property
    def streams(self) -> dict[str, Stream]:
        """The stream settings that have been changed, by camera."""
        return dict(self._streams)

    def stream(self, name: str) -> Stream:
        """Return a camera's stream settings."""
        return self._streams.get(name, Stream())

    def set_stream(self, name: str, stream: Stream) -> None:
        """Change a camera's stream settings, starting with the next picture."""
        self._streams[name] = stream

    def forget(self) -> None:
        """Start over: the next reading takes a first picture with each camera."""
        self._jobs = {}

    def read(self, sim: Simulator, name: str, camera: Camera) -> Picture | None:
        """Return the picture from the last period, or None if none was due."""

        def begin(stream: Stream) -> Callable[[], Picture]:
            capture = camera.later()

            def take() -> Picture:
                frame = capture()
                return Picture(frame, _jpeg(frame, stream), stream)

            return take

        picture: Picture | None = self.read_made(sim, name, begin)
        return picture

    def read_made(self, sim: Simulator, name: str, begin: Begin) -> Any:
        """Return the result of `begin` from the last period, or None if none was due."""
        stream, slot = self.stream(name), int(sim.time_ns * RATE_HZ // 1_000_000_000)
        jobs = [job for job in self._jobs.get(name, []) if job.slot <= slot]  # time may have gone back
        waits, pause = self._may_wait(), 1 + RATE_HZ / stream.rate_hz
        last, gap_before = self._last.get(name, (slot, 0))
        gap = slot - last
        if not waits and gap > max(pause, 2 * gap_before):  # a rare reader, such as a modem's, gets its last picture
            jobs = []
        self._last[name] = slot, gap
        is_first = not jobs or slot - jobs[-1].slot > pause
        is_due = (is_first or stream.is_due(slot)) and stream.enabled and not (jobs and jobs[-1].slot == slot)
        if is_due and (waits or not jobs or jobs[-1].picture.done()):
            before = [] if waits and is_first else jobs[-1:]
            jobs = [*before, _Job(slot, self._worker.submit(begin(stream)), is_first)]
        self._jobs[name] = jobs
        ready = [job for job in jobs if _is_read(job, slot, waits)] if stream.enabled else []
        return ready[0].picture.result() if ready else None

    def submit(self, function: Callable[[], T]) -> Future[T]:
        """Queue another rendering task on the picture thread."""
        return self._worker.submit(function)


def _is_read(job: _Job, slot: int, waits: bool) -> bool:
    """Return whether readings in this period get the picture; usually those in the next period with any do."""
    if waits and job.is_first and job.slot == slot:
        return True
    if job.read_in is None and job.slot < slot and (waits or job.picture.done()):
        job.read_in = slot
    return job.read_in == slot


def _jpeg(frame: Frame, stream: Stream) -> bytes:
    return frame.jpeg(stream.quality) if not stream.width else as_jpeg(frame.rgb, stream)


def as_jpeg(rgb: NDArray[np.uint8], stream: Stream) -> bytes:
    """Encode a picture (height, width, 3) as JPEG with the stream's width and quality."""
    from PIL import Image

    picture = Image.fromarray(rgb)
    height, width = rgb.shape[:2]
    if stream.width:
        picture = picture.resize((stream.width, max(1, round(height * stream.width / width))))
    data = io.BytesIO()
    picture.save(data, "JPEG", quality=stream.quality)
    return data.getvalue()
