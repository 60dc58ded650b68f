"""Renders the camera pictures that the page shows, at a wall-clock rate and only while they are viewed."""

from __future__ import annotations

import math
import os
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from uwsim.base.arguments import is_within
from uwsim.channels.authority.steering import is_cut_off
from uwsim.channels.delivery.pictures import WIDTHS
from uwsim.channels.families.cameras import compressed_image
from uwsim.channels.guest import GuestTopic, Node, Values
from uwsim.channels.table import Table
from uwsim.instruments.cameras import Camera, Frame
from uwsim.live import LiveSimulator, NotRunningError
from uwsim.operator.station.views.picture_size import Fit
from uwsim.simulator.simulator import Simulator

RATE_HZ, RATE_MAX_HZ = 10.0, 15.0
LARGE_WIDTH = 960  # of a picture that is larger than its camera's
ON_PACE = 0.98  # share of the requested speed that steps must reach beside large pictures
SMALL_WIDTH, SMALL_PERIOD_S, SMALL_QUALITY = 240, 0.5, 70
REDUCED_QUALITY = 92  # of a picture smaller than its camera's, which the page enlarges: without blocks
UNAWAITED_PERIOD_S = 0.5  # extra delay of pictures that no viewer is waiting for, or in which nothing can have changed
SMALL_PATIENCE_S = 1.0  # longest time that a small picture waits for large ones
POLL_S = 0.03  # interval between checks whether a due picture can be rendered
JPEG = "sensor_msgs/msg/CompressedImage"
CORES = len(os.sched_getaffinity(0))
THREADS = max(1, (os.cpu_count() or 2) - 1)  # leaves a core for the steps


@dataclass(frozen=True)
class Size:
    """Settings for rendering a view.

    width 0: the camera's own width, or less if the rate requires it, or up to LARGE_WIDTH where nothing else needs the
    cores. rate_hz None: RATE_HZ, or RATE_MAX_HZ for such large pictures.
    """

    rate_hz: float | None = None
    width: int = 0
    quality: int = 80


@dataclass(eq=False)
class Stream:
    """A topic that carries pictures from one camera."""

    topic: str
    camera: Camera
    size: Size
    frame_id: str
    due_s: float = 0.0
    begun_s: float = 0.0
    rendered: int = -1  # the simulator's version in the last picture
    job: Future[Any] | None = None
    fit: Fit | None = field(init=False)  # for a stream that may be smaller than its camera

    _fitted: Camera | None = None

    def __post_init__(self) -> None:
        self.show(self.camera, self.size)

    def fitted(self) -> Camera:
        """Return the camera at the size of the next picture."""
        width = self.camera.mount.width
        if self.fit is not None:
            width = min(round(self.fit.share * width), max(width, LARGE_WIDTH))
        if self._fitted is None or self._fitted.mount.width != width:
            self._fitted = self.camera.resized(width)  # cached, since building its ray table takes time
        return self._fitted

    def show(self, camera: Camera, size: Size) -> None:
        """Switch to pictures from another camera or of another size."""
        self.camera, self.size, self._fitted = camera, size, None
        self.fit = None if size.width else Fit()

    @property
    def period_s(self) -> float:
        """The time between pictures."""
        if self.size.rate_hz is not None:
            return 1.0 / self.size.rate_hz
        return 1.0 / (RATE_MAX_HZ if self.fit is not None and self.fit.is_large else RATE_HZ)

    @property
    def is_free(self) -> bool:
        """Whether no picture of the stream is being rendered."""
        return self.job is None or self.job.done()


@dataclass(eq=False)
class View:
    """A camera as described to the page. kind: "camera", "station" or "chase". vehicle: "" for station cameras."""

    name: str
    title: str
    kind: str
    vehicle: str
    camera: Camera
    frame_id: str
    large: Stream = field(init=False)
    small: Stream = field(init=False)

    def __post_init__(self) -> None:
        self.call("view", "small")

    def call(self, large: str, small: str) -> None:
        """Set the names of the view's topics, which are `large` and `small` followed by the view's name."""
        small_size = Size(1.0 / SMALL_PERIOD_S, SMALL_WIDTH, SMALL_QUALITY)
        whole, reduced = self.camera.resized(self.camera.mount.width), self.camera.resized(SMALL_WIDTH)
        self.large = Stream(f"station/{large}/{self.name}", whole, Size(), self.frame_id)
        self.small = Stream(f"station/{small}/{self.name}", reduced, small_size, self.frame_id)

    def described(self) -> Values:
        """Return the view's entry in `describe`."""
        mount = self.camera.mount
        return {
            "name": self.name, "title": self.title, "kind": self.kind, "vehicle": self.vehicle,
            "frame_id": self.frame_id, "width": mount.width, "height": mount.height,
            "topic": f"/{self.large.topic}", "small_topic": f"/{self.small.topic}",
            "optics": {
                "yaw_pitch_roll_deg": list(mount.yaw_pitch_roll_deg), "horizontal_fov_deg": mount.field_of_view_deg,
                "follows": mount.follows, "turns": mount.pan_tilt is not None,
            },
        }  # fmt: skip


class Views:
    """The views of one simulator. Call `beat` at the times that it returns, and after `wake`. It does not block.

    over_link: whether vehicle camera pictures are received over a link. Pictures rendered here then have different
    topics, and exist only if the truth may be shown.
    """

    def __init__(
        self,
        live: LiveSimulator,
        table: Table,
        node: Node,
        wake: Callable[[], object],
        *,
        over_link: bool = False,
        truth: bool = True,
    ) -> None:
        self._live, self._node, self._wake = live, node, wake
        self._pictures = table.pictures
        self._small_s = 0.0  # when the last small picture was started
        self.views = {view.name: view for view in _views(live.simulator, table)}
        self.aboard = {view.name for view in self.views.values() if over_link and view.vehicle}
        self._made = [view for view in self.views.values() if truth or view.name not in self.aboard]
        for name in self.aboard:
            self.views[name].call("aboard", "aboard_small")

    def topics(self) -> list[GuestTopic]:
        """Return the topics of all views."""
        return [GuestTopic(stream.topic, JPEG) for stream in self._streams()]

    def beat(self, now_s: float) -> float:
        """Start the pictures that are due. Return the time [s] until the next one, unless `wake` is called earlier."""
        wanted = [stream for stream in self._streams() if self._node.is_wanted(stream.topic)]
        passing = [view for view in self._made if not is_cut_off(self._live.simulator, view.vehicle)]
        for view in passing:
            if view.large in wanted and self._is_due(view.large, now_s):
                self._begin(view.large, now_s)
        self._begin_small([view.small for view in passing if view.small in wanted], now_s)
        return min((max(stream.due_s - now_s, POLL_S) for stream in wanted if stream.is_free), default=math.inf)

    def _begin_small(self, wanted: list[Stream], now_s: float) -> None:
        """Start one small picture at a time, normally only while no large one is being rendered."""
        due = [stream for stream in wanted if self._is_due(stream, now_s)]
        if not due or not all(view.small.is_free for view in self.views.values()):
            return
        is_quiet = all(view.large.is_free for view in self.views.values())
        if is_quiet or now_s - self._small_s > SMALL_PATIENCE_S:
            self._small_s = now_s
            self._begin(min(due, key=lambda stream: stream.begun_s), now_s)

    def _is_due(self, stream: Stream, now_s: float) -> bool:
        if not stream.is_free or now_s < stream.due_s:
            return False
        is_fresh = self._live.simulator.version != stream.rendered and self._node.is_awaited(stream.topic)
        return is_fresh or now_s >= stream.due_s + UNAWAITED_PERIOD_S

    def set_size(self, request: Values) -> None:
        """Change the size, rate or quality of a view's large stream. Raises ValueError."""
        view = self.view(request.get("name"))
        given = {name: request[name] for name in ("rate_hz", "width", "quality") if name in request}
        size = replace(view.large.size, **given)
        rates = f"in [0.1, {RATE_MAX_HZ:g}]"
        _require(size.rate_hz is None or is_within(size.rate_hz, 0.1, RATE_MAX_HZ), "rate_hz", size.rate_hz, rates)
        widths = f"0 or in {list(WIDTHS)}"
        _require(size.width == 0 or is_within(size.width, *WIDTHS, whole=True), "width", size.width, widths)
        _require(is_within(size.quality, 1, 100, whole=True), "quality", size.quality, "in [1, 100]")
        view.large.show(view.camera.resized(int(size.width) or view.camera.mount.width), size)

    def renew(self) -> None:
        """Apply changed camera lenses."""
        for view in self.views.values():
            for stream in (view.large, view.small):
                stream.show(view.camera.resized(int(stream.size.width) or view.camera.mount.width), stream.size)

    def view(self, name: object) -> View:
        """Return a view by name. Raises ValueError."""
        if not isinstance(name, str) or name not in self.views:
            raise ValueError(f"view = {str(name)[:40]!r}: must be one of {', '.join(self.views)}")
        return self.views[name]

    def capture(self, view: View, also: Callable[[Simulator], Any]) -> tuple[Frame, Any]:
        """Return a picture at the camera's full size, and the result of `also` at the same time. This blocks."""
        snapshot, read = self._live.read(lambda sim: (view.camera.snapshot(), also(sim))).result()
        camera = view.camera.resized(view.camera.mount.width)
        capture = partial(camera.capture, at=snapshot, threads=THREADS, dark_below_ground=True)
        return self._pictures.submit(capture).result(), read

    def _streams(self) -> Iterable[Stream]:
        return [stream for view in self._made for stream in (view.large, view.small)]

    def _begin(self, stream: Stream, now_s: float) -> None:
        period_s = stream.period_s
        stream.rendered, stream.begun_s = self._live.simulator.version, now_s
        stream.due_s = max(stream.due_s + period_s, now_s - period_s)
        quality, fit = int(stream.size.quality), stream.fit
        camera = stream.fitted()
        if camera.mount.width < stream.camera.mount.width:
            quality = max(quality, REDUCED_QUALITY)

        def make(snapshot: Any) -> None:
            begun_s = time.monotonic()
            frame = camera.capture(at=snapshot, threads=THREADS, dark_below_ground=True)
            message = compressed_image(frame.jpeg(quality), frame.time_ns, stream.frame_id)
            self._node.publish(stream.topic, message, frame.time_ns)
            if fit is not None:
                usual_s = 1.0 / (stream.size.rate_hz or RATE_HZ)
                took_s = time.monotonic() - begun_s
                fit.note(took_s, usual_s, has_room=self._has_room(stream), is_behind=self._live.is_behind)

        def render(snapshot: Future[Any]) -> None:
            if snapshot.exception() is None:
                stream.job = self._pictures.submit(lambda: make(snapshot.result()))
                stream.job.add_done_callback(lambda done: self._wake())

        try:
            stream.job = self._live.read(lambda sim: camera.snapshot())
            stream.job.add_done_callback(render)
        except NotRunningError:
            stream.due_s += 1.0

    def _has_room(self, stream: Stream) -> bool:
        """Return whether pictures may be larger than the camera's: its are small, and the steps keep their pace.

        With a single core, or at full speed, the steps could use all of it.
        """
        speed = self._live.speed
        if CORES < 2 or stream.size.rate_hz is not None or stream.camera.mount.width >= LARGE_WIDTH or speed == "max":
            return False
        return self._live.paused or self._live.factor >= ON_PACE * speed


def _views(sim: Simulator, table: Table) -> Iterable[View]:
    """Return the vehicle cameras, then the chase cameras, then the station cameras."""
    found = []
    for source in table.sources:
        for name, camera in source.of(sim).cameras.items():
            kind = "chase" if camera.mount.follows == "heading" else "camera"
            own, frame_id = source.topic(name), source.frame(f"{name}_optical")
            found.append(View(own, title(own), kind, source.name, camera, frame_id))
    taken = {view.name for view in found}
    for name, camera in sim.cameras.items():
        own = name if name not in taken else f"station/{name}"
        found.append(View(own, title(own), "station", "", camera, f"{name}_optical"))
    return sorted(found, key=lambda view: ["camera", "chase", "station"].index(view.kind))


def title(name: str) -> str:
    """Return a name as displayed by the page."""
    return " ".join(name.replace("_", " ").split("/")).capitalize()


def _require(holds: bool, name: str, value: object, rule: str) -> None:
    if not holds:
        raise ValueError(f"{name} = {str(value)[:40]}: must be {rule}")
