"""The paper's adaptive lawn-mower, sent to a polygon, on a vehicle's public names alone. Copy it to write another.

As published: release; go to the start; go forward while any of the first, the middle and the last beam reads more
than 7 m; turn by 180 degrees; side-step; repeat, turning the other way each time; stop when the proximity sensor
reads less than 7 m at a turn. Ours adds the polygon (a lane ends with it, the mission with its last lane) and keeps
its height above the bed and above what the sonar sees ahead.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from uwsim.control.autopilot import Autopilot, wrap_angle
from uwsim.control.protocols import Clock, PingLike, SurveyVehicle
from uwsim.missions.lanes import Lane, lawn_mower_lanes
from uwsim.missions.lookout import Lookout

COVERED = "all lanes are flown"  # what run() returns when nothing stopped it before
TURN_RANGE_M = 7.0  # as published, for the beams and for the proximity sensor
UNDOCK_M, UNDOCK_SPEED_M_S = 6.0, 0.5
ARRIVED_M = 0.5
SHALLOWEST_Z_M = -1.5  # never climbs past it
STUCK_AFTER_S = 60.0
CAPSIZED_COSINE = 0.3  # of the tilt


@dataclass(frozen=True)
class LawnMowerPlan:
    """Where and how to mow. area_m: the polygon's corners (k, 2). altitude_m: over the bed. tilt_deg: nose down."""

    area_m: Sequence[Sequence[float]]
    altitude_m: float = 8.0
    line_spacing_m: float = 5.0
    speed_m_s: float = 1.0
    tilt_deg: float = 30.0

    @property
    def reach_m(self) -> float:
        """How far ahead the tilted fan meets a flat bed; a lane begins and ends this far outside the polygon."""
        return float(np.clip(self.altitude_m / np.tan(np.radians(max(self.tilt_deg, 10.0))), 0.0, 20.0))


class StoppedError(Exception):
    """The mission ended before its last lane; the message says why."""


class AdaptiveLawnMower:
    """Flies a plan with a vehicle and a clock; uwsim.control.protocols says what of them it needs."""

    def __init__(self, vehicle: SurveyVehicle, clock: Clock, plan: LawnMowerPlan, period_s: float = 0.1) -> None:
        for sensor in ("altitude", "proximity_port"):
            if sensor not in vehicle.sensors:
                raise ValueError(f"the vehicle has no sensor '{sensor}': the lawn-mower steers by it")
        self.vehicle = vehicle
        self.clock = clock
        self.plan = plan
        self.period_s = period_s
        self.autopilot = Autopilot(vehicle, period_s)
        self.lookout = Lookout()
        self.lanes = lawn_mower_lanes(plan.area_m, plan.line_spacing_m, plan.reach_m, self._position()[:2])
        self.flown_m = 0.0

    @property
    def progress(self) -> float:
        """Share of the lanes' length that lies behind, 0..1."""
        return min(1.0, self.flown_m / sum(lane.length_m for lane in self.lanes))

    def run(self) -> str:
        """Fly until the last lane ends (COVERED) or something else ends the mission; returns what did."""
        self.vehicle.sonar.aim(-np.radians(self.plan.tilt_deg))
        try:
            if not self.vehicle.released:
                self.vehicle.release()
                self._leave_station()
            self._go_to(self.lanes[0].start_m, heading_rad=None)
            for k, lane in enumerate(self.lanes):
                heading = _heading(lane.direction)
                self._turn_to(heading, port=k % 2 == 0)
                if k > 0:
                    self._require_room_to_port()
                self._go_to(self._abreast(lane), heading)
                self._fly(lane)
        except StoppedError as stop:
            return str(stop)
        finally:
            self.vehicle.set_effort()
        return COVERED

    def _leave_station(self) -> None:
        """Straight ahead and level until clear of the dock."""
        start = self._position()
        heading = self.vehicle.pose.yaw_rad
        ahead = np.array([np.cos(heading), np.sin(heading)])
        begun_s = self.clock.time_s
        while np.linalg.norm(self._position() - start) < UNDOCK_M:
            if self.clock.time_s > begun_s + STUCK_AFTER_S:
                raise StoppedError("stuck in the station's dock")
            self._command(heading, UNDOCK_SPEED_M_S * ahead, start[2])

    def _abreast(self, lane: Lane) -> NDArray[np.float64]:
        """The point of the lane beside the vehicle: its start, or further on where the last lane was cut short."""
        along, _ = lane.locate(self._position()[:2])
        return lane.start_m + float(np.clip(along, 0.0, lane.length_m)) * lane.direction

    def _fly(self, lane: Lane) -> None:
        """Forward along the lane while there is water ahead."""
        begun_m, furthest_m, furthest_s = self.flown_m, 0.0, self.clock.time_s
        heading = _heading(lane.direction)
        while True:
            along, across = lane.locate(self._position()[:2])
            self.flown_m = begun_m + float(np.clip(along, 0.0, lane.length_m))
            if along >= lane.length_m or not self._water_ahead(self.vehicle.sonar.ping()):
                break
            if along > furthest_m + ARRIVED_M:
                furthest_m, furthest_s = along, self.clock.time_s
            elif self.clock.time_s > furthest_s + STUCK_AFTER_S:
                raise StoppedError(f"stuck {along:.0f} m into a lane")
            to_line = -0.5 * np.clip(across, -2.0, 2.0) * np.array([-lane.direction[1], lane.direction[0]])
            self._steer(heading, self.plan.speed_m_s * lane.direction + to_line)
        self.flown_m = begun_m + lane.length_m

    def _water_ahead(self, ping: PingLike) -> bool:
        """The published rule: any of the first, the middle and the last beam reads more than 7 m."""
        ranges = ping.ranges_m
        return bool(np.any(ranges[[0, len(ranges) // 2, -1]] > TURN_RANGE_M))

    def _turn_to(self, heading_rad: float, *, port: bool) -> None:
        """Turn on the spot, a half turn the way asked for."""
        direction = 1.0 if port else -1.0
        here = self._position()[:2]
        begun_s = self.clock.time_s
        while abs(left := wrap_angle(heading_rad - self.vehicle.pose.yaw_rad)) > np.radians(5.0):
            if self.clock.time_s > begun_s + STUCK_AFTER_S:
                raise StoppedError(f"stuck in a turn, {np.degrees(left):.0f} degrees before its end")
            half_turn_ahead = abs(left) > np.radians(120.0)
            aim = self.vehicle.pose.yaw_rad + direction * np.radians(60.0) if half_turn_ahead else heading_rad
            self._steer(aim, 0.3 * (here - self._position()[:2]))

    def _require_room_to_port(self) -> None:
        """The published end: something near to port at a turn."""
        port_m = self.vehicle.sensors["proximity_port"].read()
        if port_m < TURN_RANGE_M:
            raise StoppedError(f"the proximity sensor reads {port_m:.1f} m at a turn")

    def _go_to(self, point_m: NDArray[np.float64], heading_rad: float | None) -> None:
        """To a point: facing it when no heading is given, else side-stepping with the heading held."""
        begun_s = self.clock.time_s
        allowed_s = STUCK_AFTER_S + 5.0 * float(np.linalg.norm(point_m - self._position()[:2])) / self.plan.speed_m_s
        while (distance := float(np.linalg.norm(way := point_m - self._position()[:2]))) > ARRIVED_M:
            if self.clock.time_s > begun_s + allowed_s:
                raise StoppedError(f"stuck {distance:.0f} m before ({point_m[0]:.0f}, {point_m[1]:.0f}) m")
            heading = heading_rad if heading_rad is not None else _heading(way)
            speed = min(self.plan.speed_m_s, 0.2 + 0.3 * distance)
            if abs(wrap_angle(heading - self.vehicle.pose.yaw_rad)) > np.radians(30.0):
                speed = 0.0  # turn first, so that the sonar looks where the vehicle goes
            self._steer(heading, speed * way / distance)

    def _steer(self, heading_rad: float, velocity_world_m_s: NDArray[np.float64]) -> None:
        """One control period, at a safe height over what is known of the way."""
        position = self._position()
        yaw = self.vehicle.pose.yaw_rad
        self.lookout.see(self.vehicle.sonar.ping(), position, yaw)
        bed_m = position[2] - self.vehicle.sensors["altitude"].read()
        wanted_m = max(bed_m, self.lookout.highest_m(position, yaw)) + self.plan.altitude_m
        target_m = min(wanted_m if np.isfinite(wanted_m) else position[2], SHALLOWEST_Z_M)
        # Slow down while the climb is still ahead.
        slower = np.clip(1.0 - (target_m - position[2] - 1.0) / 4.0, 0.1, 1.0)
        self._command(heading_rad, slower * velocity_world_m_s, target_m)

    def _command(self, heading_rad: float, velocity_world_m_s: NDArray[np.float64], z_world_m: float) -> None:
        """One control period, while there is power."""
        if self.vehicle.telemetry().battery_percent <= 0.0:
            raise StoppedError("the battery is used up")
        if self.vehicle.pose.world_from_body[2, 2] < CAPSIZED_COSINE:
            raise StoppedError("capsized: the vehicle has nosed or rolled over")
        self.autopilot.steer(heading_rad, velocity_world_m_s, z_world_m)
        self.clock.wait(self.period_s)

    def _position(self) -> NDArray[np.float64]:
        return np.asarray(self.vehicle.pose.position_world_m, np.float64)


def _heading(direction: NDArray[np.float64]) -> float:
    return float(np.arctan2(direction[1], direction[0]))
