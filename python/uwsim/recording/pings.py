"""The pings in a recording, with the exact poses at which they were taken, from which maps are built."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.channels import Channel
from uwsim.channels.families.pings import Pings, TakenPing
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import SONAR_PING
from uwsim.mapping.ranging import place_deviation_m
from uwsim.simulator.simulator import Simulator

if TYPE_CHECKING:
    from uwsim.recording.messages import Messages


NAME = "sonar_ping"


def ping_channel(pings: Pings) -> Channel:
    """Return the channel of a vehicle's pings, in odom. It is recorded but not published."""
    source = pings.source
    frame_id = source.frame("odom")

    def read(sim: Simulator) -> Any:
        taken = pings.newest(sim)
        panel = source.of(sim).telemetry()
        return ping_message(taken.ping, panel, frame_id, taken.odom_from_body, taken.odom_from_sonar)

    return Channel(
        source.topic(NAME), SONAR_PING, "out", "each ping as taken, with the poses of body and sonar",
        rate_hz=pings.rate_hz, frame_id=frame_id, read=read,
    )  # fmt: skip


def survey_ping(sim: Simulator) -> Any:
    """Return a ping from the first vehicle at the current time, in the world frame, as in a survey."""
    rov = sim.rov
    ping = rov.sonar.ping()
    return ping_message(ping, rov.telemetry(), "world", rov.pose.world_from_body, ping.world_from_sonar)


def ping_message(
    ping: _core.Ping,
    panel: _core.Telemetry,
    frame_id: str,
    frame_from_body: NDArray[np.float64],
    frame_from_sonar: NDArray[np.float64],
) -> Any:
    """Return a ping as a message; poses are (4, 4)."""
    deviation_m, horizontal_m = place_deviation_m(ping), getattr(ping, "horizontal_deviation_m", ())
    return build.message(
        SONAR_PING,
        header=build.header(ping.time_ns, frame_id),
        ranges=ping.ranges_m,
        angles=np.asarray(ping.angles_rad, np.float32),
        valid=np.asarray(ping.valid, bool),
        labels=np.asarray(ping.labels, np.int32),
        intensities=np.asarray(ping.intensity_db, np.float32),
        frame_from_body=np.asarray(frame_from_body, np.float64).ravel(),
        frame_from_sonar=np.asarray(frame_from_sonar, np.float64).ravel(),
        range_warning=bool(panel.range_warning),
        proximity_warning=bool(panel.proximity_warning),
        collision_warning=bool(panel.collision_warning),
        deviations=np.empty(0, np.float32) if deviation_m is None else deviation_m,
        horizontal_deviations=np.asarray([] if deviation_m is None else horizontal_m, np.float32),
    )


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
