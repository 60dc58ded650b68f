"""A vehicle in a MOOS community: it is there what uSimMarine is, on our dynamics."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim.base.axes import AXES
from uwsim.bridges.aboard.aboard import Aboard
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.moos.client import MoosClient, logger
from uwsim.bridges.moos.reports import OWN, NodeReports
from uwsim.bridges.moos.variables import depth_m, instruments, is_true, latest, navigation, number, ping_summary
from uwsim.bridges.moos.wire import Message
from uwsim.bridges.rare_log import RareLog
from uwsim.channels import Channel
from uwsim.channels.authority.steering import CONTROL_S
from uwsim.channels.channel import ended_by
from uwsim.channels.delivery.feed import Reading
from uwsim.live import LiveSimulator
from uwsim.mapping.files.georeference import Georeference
from uwsim.navigation.control.controller import Controller
from uwsim.simulator.simulator import Simulator

ACTUATORS = ("DESIRED_THRUST", "DESIRED_RUDDER", "DESIRED_ELEVATOR")
SETPOINTS = ("DESIRED_SPEED", "DESIRED_HEADING", "DESIRED_DEPTH")
OVERRIDES = ("MOOS_MANUAL_OVERRIDE", "MOOS_MANUAL_OVERIDE")  # the second is how MOOS once spelled it
PAUSED = "USM_SIM_PAUSED"
NAME = "moos"
"""The name of the source that steers, in helms and refusals."""
FULL_PERCENT = 100.0


@dataclass(frozen=True)
class Settings:
    """The settings of a community's vehicle. name: of the application. rate_hz: of its publications [Hz].

    by_setpoints: whether DESIRED_SPEED, HEADING and DEPTH steer it, instead of DESIRED_THRUST, RUDDER and ELEVATOR.
    from_truth: whether NAV_* is the true motion. full_elevator_deg: the elevator at full effort [deg].
    """

    name: str = "uwsim"
    rate_hz: float = 10.0
    by_setpoints: bool = False
    from_truth: bool = False
    full_elevator_deg: float = 13.0


class CommunityVehicle:
    """Publishes a vehicle's state to a MOOSDB, and steers it as the community desires.

    What is desired ends like a topic's command when the community falls silent, and loses the helm to a pilot. reports:
    takes the community's own node reports to the others, if wanted. Use it as a context.
    """

    def __init__(
        self,
        live: LiveSimulator,
        aboard: Aboard,
        address: Endpoint,
        place: Georeference,
        settings: Settings,
        reports: NodeReports | None = None,
    ) -> None:
        self._live, self._place, self._settings = live, place, settings
        self.vehicle, self._steering = aboard.source.name, aboard.steering
        self._desired: dict[str, float] = {}
        self._is_overridden = False
        self._rare = RareLog(logger)
        self._drives = frozenset(live.simulator.vehicles[self.vehicle].controllable)
        self._reports = reports
        names = (*(SETPOINTS if settings.by_setpoints else ACTUATORS), *OVERRIDES, PAUSED, *([OWN] if reports else ()))
        self.client = MoosClient(address, settings.name, names, self._on_messages, self._on_met)
        apply: Callable[[LiveSimulator, Any], object] = self._steer if settings.by_setpoints else self._act
        self._channel = Channel(
            aboard.source.topic(NAME), "MOOS", "in", "what a MOOS community desires", apply=apply,
            authority=ended_by({}, self._idle, self._steering),
        )  # fmt: skip
        if reports is not None:
            reports.join(self.vehicle, self.client)
        self._subscription = live.every(1.0 / settings.rate_hz, self._read, self.client.publish)

    def __enter__(self) -> CommunityVehicle:
        self.client.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Leave the community."""
        self._subscription.cancel()
        self.client.close()

    def take_ping(self, reading: Reading) -> None:
        """Publish a ping of the sonar, a sensor_msgs/LaserScan, as UWSIM_SONAR. Does not block."""
        scan = reading.message
        ranges_m = np.asarray(scan.ranges, np.float64)
        bearings_rad = scan.angle_min + scan.angle_increment * np.arange(len(ranges_m))
        stamp = scan.header.stamp
        self.client.publish([("UWSIM_SONAR", ping_summary(ranges_m, bearings_rad, stamp.sec + 1e-9 * stamp.nanosec))])

    def _read(self, sim: Simulator) -> list[tuple[str, float | str]]:
        vehicle = sim.vehicles[self.vehicle]
        if not self.client.is_met:
            return []
        found = navigation(vehicle, self._place, from_truth=self._settings.from_truth)
        found += [*instruments(vehicle), ("UWSIM_TIME", sim.time_s)]
        if self._settings.from_truth:
            found += [("TRUE_X", found[0][1]), ("TRUE_Y", found[1][1])]
        return found

    def _on_met(self, community: str, warp: float) -> None:
        logger.info("community '%s' at %s: time warp %g", community, self.client.address, warp)
        if self._live.speed != warp:
            with self._live.privileged():
                self._live.speed = warp

    def _on_messages(self, messages: list[Message]) -> None:
        values = latest(messages)
        try:
            for name in OVERRIDES:
                if name in values:
                    self._is_overridden = is_true(values[name])
            if PAUSED in values:
                (self._live.pause if is_true(values[PAUSED]) else self._live.resume)()
            if OWN in values and self._reports is not None:
                self._reports.send(self.vehicle, values[OWN])
            names = SETPOINTS if self._settings.by_setpoints else ACTUATORS
            desired = {name: found for name in names if name in values and (found := number(values[name])) is not None}
            if desired or (self._is_overridden and self._desired):
                self._desired = {} if self._is_overridden else {**self._desired, **desired}
                self._steering.apply(self._live, self._channel, dict(self._desired), "a MOOS community")
        except (ValueError, RuntimeError) as error:
            self._rare.warning(f"community '{self.client.community}': {error}")

    def efforts(self, desired: Mapping[str, float]) -> dict[str, float]:
        """Return efforts for thrust [%], rudder [%] and elevator [deg]: to starboard and down are positive."""

        def share(name: str, full: float) -> float:
            return max(-1.0, min(1.0, desired.get(name, 0.0) / full))

        down = share("DESIRED_ELEVATOR", self._settings.full_elevator_deg)
        by_pitch = "heave" not in self._drives
        return {
            "surge": share("DESIRED_THRUST", FULL_PERCENT),
            "yaw": -share("DESIRED_RUDDER", FULL_PERCENT),
            "heave": 0.0 if by_pitch else -down,
            "pitch": down if by_pitch and "pitch" in self._drives else 0.0,
        }

    def _act(self, live: LiveSimulator, desired: Mapping[str, float]) -> None:
        self._steering.give(live, "set_effort", **self.efforts(desired))

    def _idle(self, live: LiveSimulator, desired: Mapping[str, float]) -> None:
        self._desired = {}
        self._steering.give(live, "set_effort")

    def _steer(self, live: LiveSimulator, desired: Mapping[str, float]) -> None:
        """Hold a course by our own control loops, until another command steers."""
        if not desired:
            self._idle(live, desired)
            return
        self._steering.control(live, NAME, self._loop)

    def _loop(self, vehicle: Any) -> Callable[[], dict[str, float]]:
        """Return the function that is called once per control period for the efforts."""
        controller = Controller(
            vehicle, CONTROL_S, estimate=None if self._settings.from_truth else vehicle.start_navigation()
        )

        def efforts() -> dict[str, float]:
            desired, pose = self._desired, controller.estimate.pose
            north_rad = self._place.north_rad(np.asarray(pose.position_world_m)) if self._place.crs is not None else 0.0
            course_rad = pose.yaw_rad
            if "DESIRED_HEADING" in desired:
                course_rad = math.pi / 2 - math.radians(desired["DESIRED_HEADING"]) + north_rad
            speed_m_s = desired.get("DESIRED_SPEED", 0.0)
            ahead = speed_m_s * np.array([math.cos(pose.yaw_rad), math.sin(pose.yaw_rad)])
            height_m = None
            if "DESIRED_DEPTH" in desired:
                too_deep_m = depth_m(vehicle, from_truth=self._settings.from_truth) - desired["DESIRED_DEPTH"]
                height_m = float(pose.position_world_m[2]) + too_deep_m
            found = controller.steer_efforts(course_rad, ahead, height_m)
            return dict(zip(AXES, found, strict=True))

        return efforts
