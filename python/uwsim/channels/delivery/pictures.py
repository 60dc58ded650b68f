"""Pictures of cameras and imaging sonars, each rendered once for all clients, in parallel with the steps."""

from __future__ import annotations

import io
import math
import time
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, Literal, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from uwsim.instruments.cameras import Camera, Frame
from uwsim.instruments.cameras.lens import rectify
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

    @property
    def pause(self) -> float:
        """The number of periods without a reading that count as a pause."""
        return 1 + RATE_HZ / self.rate_hz

    def is_due(self, slot: int) -> bool:
        """Return whether a picture is sent in the period with this index. A period lasts 1 / RATE_HZ."""
        share = self.rate_hz / RATE_HZ
        return self.enabled and int(slot * share + 1e-6) != int((slot - 1) * share + 1e-6)


Part = Literal["image", "rectified", "rectified_depth", "drawn"]
"""Parts of a result that take time to make, so that each is made only if it is read."""


class Parted(Protocol):
    """A result whose parts are made on first access."""

    def __contains__(self, part: Part) -> bool:
        """Return whether a part has been made."""

    def part(self, part: Part) -> Any:
        """Return a part, making it on first access."""


class Picture:
    """A frame, its JPEG and the stream's settings at the time. capture: the result of Camera.later()."""

    def __init__(self, frame: Frame, stream: Stream, capture: Callable[..., Frame] | None = None) -> None:
        self.frame, self.stream, self._capture = frame, stream, capture
        self.jpeg = frame.jpeg(stream.quality) if not stream.width else as_jpeg(frame.rgb, stream)
        self._parts: dict[Part, NDArray[Any]] = {}

    def __contains__(self, part: Part) -> bool:
        return part in self._parts

    @property
    def intrinsics(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """K (3, 3) and P (3, 4) at the size at which the picture is sent."""
        info = self.frame.info
        scale = self.stream.width / info.width if self.stream.width else 1.0
        # Pixel centres are at integer coordinates: u' + 0.5 = scale (u + 0.5).
        resize = np.array([[scale, 0.0, 0.5 * scale - 0.5], [0.0, scale, 0.5 * scale - 0.5], [0.0, 0.0, 1.0]])
        return resize @ info.k, resize @ info.p

    def part(self, part: Part) -> NDArray[Any]:
        """Return a part, making it on first access.

        image: (h, w, 3) uint8, at the size at which the picture is sent. rectified: the same, as seen by a pinhole
        camera. rectified_depth: (H, W) float32 [m] at full size, along the optical axis of the pinhole camera.
        """
        if part not in self._parts:
            self._parts[part] = self._made(part)
        return self._parts[part]

    def _made(self, part: Part) -> NDArray[Any]:
        if part == "rectified_depth":
            assert self._capture is not None
            return self._capture(geometry_rectified=True).depth_m
        if part == "image":
            width = self.stream.width
            return np.asarray(resized(self.frame.rgb, width)) if width else self.frame.rgb
        k, p = self.intrinsics
        return rectify(self.part("image"), k, self.frame.info.d, p)


Begin = Callable[[Stream], Callable[[], Parted]]
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
    picture and returns it, so results do not depend on how long rendering takes. If the steps may not wait, the picture
    is returned in the first period in which it is ready. No other picture is started until then, so pictures are
    skipped if the machine is too slow. After a pause in reading, earlier pictures are dropped, so that a new subscriber
    receives none of them.

    may_wait: called at each reading; returns whether the steps may wait. is_behind: whether steps that may not wait are
    slower than requested. Then a stream has no more pictures in a second of wall time than in one of simulated time.
    """

    def __init__(
        self, may_wait: Callable[[], bool] = lambda: True, is_behind: Callable[[], bool] = lambda: False
    ) -> None:
        self._may_wait = may_wait
        self._is_behind = is_behind
        self._begun_s: dict[str, float] = {}  # wall time at which each stream's last picture was begun
        self._streams: dict[str, Stream] = {}
        self._jobs: dict[str, list[_Job]] = {}
        self._wanted: dict[tuple[str, Part], int] = {}  # period of the last reading of a camera's part
        self._last: dict[str, tuple[int, int]] = {}  # period of each camera's last reading, and the gap before it
        self._worker = ThreadPoolExecutor(1, "uwsim-pictures")

    @property
    def streams(self) -> dict[str, Stream]:
        """The stream settings that have been changed, by camera."""
        return dict(self._streams)

    def stream(self, name: str) -> Stream:
        """Return a camera's stream settings."""
        return self._streams.get(name, Stream())

    def begin_stream(self, name: str, camera: Camera) -> None:
        """Give a camera's stream the camera's own rate."""
        if camera.mount.rate_hz != RATE_HZ:
            self._streams[name] = Stream(rate_hz=camera.mount.rate_hz)

    def set_stream(self, name: str, stream: Stream) -> None:
        """Change a camera's stream settings, starting with the next picture."""
        self._streams[name] = stream

    def forget(self) -> None:
        """Start over: the next reading takes a first picture with each camera."""
        self._jobs = {}

    def read(self, sim: Simulator, name: str, camera: Camera, part: Part | None = None) -> Picture | None:
        """Return the picture from the last period, or None if none was due. part: as in `read_made`."""

        def begin(stream: Stream) -> Callable[[], Picture]:
            capture = camera.later()
            return lambda: Picture(capture(), stream, capture)

        picture: Picture | None = self.read_made(sim, name, begin, part)
        return picture

    def read_made(self, sim: Simulator, name: str, begin: Begin, part: Part | None = None) -> Any:
        """Return the result of `begin` from the last period, or None if none was due.

        part: a part that the result must have. If no one has read this part before, the last result lacks it. The part
        is then made now if the simulator may wait for it; otherwise None is returned.
        """
        stream, slot = self.stream(name), _slot(sim)
        if part is not None:
            self._wanted[name, part] = slot
        jobs = [job for job in self._jobs.get(name, []) if job.slot <= slot]  # time may have gone back
        waits, pause = self._may_wait(), stream.pause
        last, gap_before = self._last.get(name, (slot, 0))
        gap = slot - last
        if not waits and gap > max(pause, 2 * gap_before):  # an infrequent reader, such as a modem, gets the last one
            jobs = []
        self._last[name] = slot, gap
        is_first = not jobs or slot - jobs[-1].slot > pause
        is_due = (is_first or stream.is_due(slot)) and stream.enabled and not (jobs and jobs[-1].slot == slot)
        if is_due and (waits or self._may_begin(name, stream, jobs)):
            before = [] if waits and is_first else jobs[-1:]
            jobs = [*before, _Job(slot, self._worker.submit(self._task(name, slot, stream, begin)), is_first)]
        self._jobs[name] = jobs
        ready = [job for job in jobs if _is_read(job, slot, waits)] if stream.enabled else []
        found = ready[0].picture.result() if ready else None
        if found is None or part is None or part in found:
            return found
        if not waits:
            return None
        self._worker.submit(found.part, part).result()
        return found

    def _task(self, name: str, slot: int, stream: Stream, begin: Begin) -> Callable[[], Parted]:
        """Return a function that makes a result with the parts that have been read lately."""
        make = begin(stream)
        parts = [each for (whose, each), last in self._wanted.items() if whose == name and slot - last <= stream.pause]

        def take() -> Parted:
            made = make()
            for each in parts:
                made.part(each)
            return made

        return take

    def _may_begin(self, name: str, stream: Stream, jobs: list[_Job]) -> bool:
        """Return whether the worker has time for a picture for which no step waits."""
        if jobs and not jobs[-1].picture.done():
            return False
        now_s = time.monotonic()
        if self._is_behind() and now_s - self._begun_s.get(name, -math.inf) < 1.0 / stream.rate_hz:
            return False
        self._begun_s[name] = now_s
        return True

    def submit(self, function: Callable[[], T]) -> Future[T]:
        """Queue another rendering task on the picture thread."""
        return self._worker.submit(function)


def _is_read(job: _Job, slot: int, waits: bool) -> bool:
    """Return whether readings in this period get the picture, which is usually the next period with readings."""
    if waits and job.is_first and job.slot == slot:
        return True
    if job.read_in is None and job.slot < slot and (waits or job.picture.done()):
        job.read_in = slot
    return job.read_in == slot


def _slot(sim: Simulator) -> int:
    """Return the index of the current period."""
    return int(sim.time_ns * RATE_HZ // 1_000_000_000)


def as_jpeg(rgb: NDArray[np.uint8], stream: Stream) -> bytes:
    """Encode a picture (height, width, 3) as JPEG with the stream's width and quality."""
    data = io.BytesIO()
    resized(rgb, stream.width).save(data, "JPEG", quality=stream.quality)
    return data.getvalue()


def resized(rgb: NDArray[np.uint8], width: int) -> Any:
    """Resize a picture (height, width, 3) to a width; return a PIL image. A width of 0 keeps the original size."""
    from PIL import Image

    height, own_width = rgb.shape[:2]
    picture = Image.fromarray(rgb)
    return picture.resize((width, max(1, round(height * width / own_width)))) if width else picture
