"""Moments: renders a recording's pictures during a replay, at their simulated times; what recording them costs."""

from __future__ import annotations

import dataclasses
import hashlib
import time
from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Iterable, Sequence
from typing import Any

from uwsim.base.agenda import NEVER
from uwsim.base.journal import JUMPS
from uwsim.channels import Channel
from uwsim.channels.delivery.pictures import RATE_HZ, Pictures, Stream
from uwsim.channels.ros.cdr import encode
from uwsim.instruments.cameras import Camera
from uwsim.recording.messages import Recorded
from uwsim.simulator.simulator import Simulator


def picture_cost_text(sim: Simulator) -> str:
    """Return a text with the processor time that the cameras' pictures take per simulated second, at full rate.

    This takes one picture with each camera, which does not change the simulator.
    """
    cameras = [*sim.cameras.values(), *(each for rov in sim.vehicles.values() for each in rov.cameras.values())]
    cost_s = RATE_HZ * sum(picture_cost_s(camera) for camera in cameras)
    return (
        f"about {cost_s:.1f} s of processor time per simulated second for the pictures of {len(cameras)} cameras; at "
        "real-time pace, pictures that are late are left out"
    )


def picture_cost_s(camera: Camera) -> float:
    """Return the processor time [s] to render and encode one picture on this thread."""
    snapshot = camera.snapshot()
    begun_s = time.thread_time()
    camera.capture(at=snapshot, threads=1).jpeg(Stream().quality)
    return time.thread_time() - begun_s


class Moments:
    """An observer that renders pictures when the simulator reaches their time stamps.

    At wall-clock speed, rendering of a picture is started by the first reader after the previous picture is ready. Its
    time depends on the machine and on all readers, and is known only from the recorded stamps. A command at the same
    tick may have come before or after the picture, so pictures are rendered before and after each command. The content
    of a CompressedImage depends only on its time. Its format depends on the topic and is copied. For other types,
    several topics have the same frame, and all recorded ones are read.
    """

    def __init__(
        self, sim: Simulator, channels: Iterable[Channel], pictures: Pictures, recorded: Iterable[Recorded]
    ) -> None:
        """channels: the channels that carry pictures. recorded: the messages to render."""
        self._sim = sim
        self._pictures = pictures
        step_ns = round(sim.step_s * 1e9)
        self._due: dict[int, set[tuple[str, str, str | None]]] = defaultdict(set)
        topics = set()
        for each in recorded:
            topics.add(each.topic)
            header = each.message.header
            stamp_ns = header.stamp.sec * 1_000_000_000 + header.stamp.nanosec
            picture_format = getattr(each.message, "format", None)
            self._due[stamp_ns // step_ns].add((each.type, header.frame_id, picture_format))
        by_kind: dict[tuple[str, str], list[Channel]] = defaultdict(list)
        for channel in channels:
            by_kind[channel.type, channel.frame_id].append(channel)
        self._by_kind = {
            kind: [channel for channel in found if channel.name in topics] or found[:1]
            for kind, found in by_kind.items()
        }
        self._ticks: Sequence[int] = sorted(self._due)
        self._seen: set[bytes] = set()
        self.due_tick = NEVER

    def start(self) -> None:
        """Render the pictures that are due now, and start observing."""
        self.again()
        self._sim.journal.attach(self)

    def stop(self) -> None:
        """Stop observing."""
        self._sim.journal.detach(self)

    def observe(self) -> None:
        """Render the pictures that are due."""
        self.again()

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """After a jump in time, resume at the point where time continues."""
        if name in JUMPS:
            self._set_due(bisect_left(self._ticks, self._sim.tick))

    def again(self) -> None:
        """Render the pictures that are due again, since a command may have changed the view."""
        tick = self._sim.tick
        self._set_due(bisect_right(self._ticks, tick))
        if tick not in self._due:
            return
        self._pictures.forget()  # so that pictures are rendered again for the current state
        for type_name, frame_id, picture_format in self._due[tick]:
            for channel in self._by_kind.get((type_name, frame_id), ()):
                message = channel.read(self._sim)
                if message is not None:
                    if picture_format is not None:
                        message = dataclasses.replace(message, format=picture_format)
                    self._seen.add(_digest(type_name, encode(message)))

    def shows(self, recorded: Recorded) -> bool:
        """Return whether a recorded picture was rendered byte-identically."""
        return _digest(recorded.type, recorded.data) in self._seen

    def _set_due(self, place: int) -> None:
        self.due_tick = self._ticks[place] if place < len(self._ticks) else NEVER


def _digest(kind: str, data: bytes | memoryview) -> bytes:
    return hashlib.blake2b(data, key=kind.encode()[:64], digest_size=16).digest()
