"""The channel of a multibeam's pings and the exact poses at which they were taken, from which maps are built."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.channels import Channel
from uwsim.channels.families.pings import Pings
from uwsim.channels.ros import build
from uwsim.channels.ros.own_types import SONAR_PING
from uwsim.mapping.ranging import place_deviation_m
from uwsim.simulator.simulator import Simulator

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
