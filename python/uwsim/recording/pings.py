"""The pings in a recording, in the format that mapping needs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.channels.families.pings import TakenPing
from uwsim.recording.ping_channel import NAME

if TYPE_CHECKING:
    from uwsim.recording.messages import Messages


@dataclass(frozen=True, eq=False)
class RecordedPing:
    """A ping with the attributes of _core.Ping.

    ranges_m, angles_rad, valid, labels, intensity_db: (beams,); world_from_sonar (4, 4). vertical_deviation_m,
    horizontal_deviation_m: (beams,), of the echoes' places, None in geometry mode.
    """

    time_ns: int
    ranges_m: NDArray[np.float32]
    angles_rad: NDArray[np.float32]
    valid: NDArray[np.bool_]
    labels: NDArray[np.int32]
    intensity_db: NDArray[np.float32]
    world_from_sonar: NDArray[np.float64]
    vertical_deviation_m: NDArray[np.float64] | None = None
    horizontal_deviation_m: NDArray[np.float32] | None = None


class Panel(NamedTuple):
    """The warnings shown on the vehicle's panel at the time of a ping."""

    range_warning: bool
    proximity_warning: bool
    collision_warning: bool


def ping_topic(recording: Messages, vehicle: str | None = None) -> str:
    """Return the channel with a vehicle's pings, by default of the first vehicle that has any. Raises ValueError."""
    topics = [name for name in recording.channels if name == NAME or name.endswith("/" + NAME)]
    if not topics:
        raise ValueError(f"recording '{recording.path}': holds no pings ({NAME})")
    if vehicle is None:
        return topics[0]
    wanted = f"{vehicle}/{NAME}"
    if wanted in topics:
        return wanted
    raise ValueError(f"vehicle = {vehicle!r}: recording '{recording.path}' has {', '.join(topics)}")


def recorded_pings(recording: Messages, topic: str) -> Iterator[tuple[TakenPing, Panel]]:
    """Yield the pings on a channel in order, each with the poses at which it was taken."""
    for recorded in recording.messages(topic):
        message = recorded.message
        panel = Panel(message.range_warning, message.proximity_warning, message.collision_warning)
        yield taken_ping(message), panel


def taken_ping(message: Any) -> TakenPing:
    """Return the ping in a message of type SONAR_PING."""
    body, sonar = message.frame_from_body.reshape(4, 4), message.frame_from_sonar.reshape(4, 4)
    stamp = message.header.stamp
    deviations, horizontal = message.deviations, message.horizontal_deviations
    vertical = None
    if len(horizontal):
        with np.errstate(invalid="ignore"):  # unknown ones are infinite
            vertical = np.sqrt(np.maximum(0.0, np.square(deviations, dtype=float) - np.square(horizontal, dtype=float)))
    ping = RecordedPing(
        stamp.sec * 1_000_000_000 + stamp.nanosec,
        message.ranges,
        message.angles,
        np.asarray(message.valid, bool),
        message.labels,
        message.intensities,
        sonar,
        vertical,
        horizontal if len(horizontal) else None,
    )
    return TakenPing(cast(_core.Ping, ping), body, sonar, deviations if len(deviations) else None)
