"""The topic `to_station`, a vehicle's distance to the station, and the service `where`."""

from __future__ import annotations

from typing import Any

from uwsim.channels import Channel, OverLink, Service
from uwsim.channels.request import Request, answered
from uwsim.channels.ros import build
from uwsim.channels.source import Source
from uwsim.live import LiveSimulator
from uwsim.simulator import Simulator


def wire(source: Source, truth: bool) -> list[Channel | Service]:
    """Return the topic and the service of a vehicle, unless its true motion is hidden."""

    def read(sim: Simulator) -> Any:
        return build.message("std_msgs/msg/Float64", data=source.of(sim).telemetry().distance_to_station_m)

    def where(live: LiveSimulator, request: Request) -> str:
        return live.read(lambda sim: str(source.of(sim).pose.position_world_m.round(1))).result()

    name, type_ = source.topic("to_station"), "std_msgs/msg/Float64"
    found = [
        Channel(name, type_, "out", "distance to the station [m]", rate_hz=2.0, over_link=OverLink(), read=read),
        Service(source.topic("where"), "std_srvs/srv/Trigger", answered(where), "its true position"),
    ]
    return found if truth else []
