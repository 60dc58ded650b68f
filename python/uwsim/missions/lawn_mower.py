"""The paper's adaptive lawn-mower, sent to a polygon, on a vehicle's public names alone. Copy it to write another.

As published: release; go to the start; go forward while any of the first, the middle and the last beam reads more
than 7 m; turn by 180 degrees; side-step; repeat, turning the other way each time; stop when the proximity sensor
reads less than 7 m at a turn. Ours adds the polygon (a lane ends with it, the mission with its last lane) and keeps
its height above the bed and above what the sonar sees ahead.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge
from numpy.typing import NDArray

from uwsim.control.autopilot import Autopilot, wrap_angle
from uwsim.control.protocols import Clock, PingLike, SurveyVehicle
from uwsim.missions.lanes import Lane, lawn_mower_lanes
from uwsim.missions.lookout import Lookout
from uwsim.missions.saved import checked_state

LegName = Literal["undock", "approach", "tilt", "turn", "abreast", "mow"]
COVERED = "all lanes are flown"  # what run() returns when nothing stopped it before
TURN_RANGE_M = 7.0  # as published, for the beams and for the proximity sensor
UNDOCK_M, UNDOCK_SPEED_M_S = 6.0, 0.5
ARRIVED_M = 0.5
SHALLOWEST_Z_M = -1.5  # never climbs past it
STUCK_AFTER_S = 60.0
TILT_RAD = np.radians(0.5)  # near enough
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


@dataclass(frozen=True)
class LegStart:
    """Where and when a leg began."""

    time_s: float
    position_world_m: tuple[float, float, float]
    yaw_rad: float


@dataclass
class MowerState:
    """How far the mission is: plain data, from which another process can fly on.

    lanes_near_m: where the mission began; it orders the lanes. lane: its index. leg: what is being flown of it, and
    leg_start: None until it is. along_m: how far along the lane, furthest_m: at most, reached at furthest_s.
    """

    lanes_near_m: tuple[float, float]
    leg: LegName
    lane: Annotated[int, Ge(0)] = 0
    leg_start: LegStart | None = None
    along_m: float = 0.0
    furthest_m: float = 0.0
    furthest_s: float = 0.0


@dataclass
class SavedMission:
    """What `AdaptiveLawnMower.save` gives: its state, the autopilot's sums and the lookout's peaks."""

    mower: MowerState
    autopilot: tuple[float, float, float]
    lookout: list[tuple[float, float, float]]


class AdaptiveLawnMower:
    """Flies a plan with a vehicle and a clock; uwsim.control.protocols says what of them it needs.

    First the legs "undock", "approach" and "tilt", then "turn", "abreast" and "mow" of each lane. All that a leg
    remembers from one control period to the next is in `state`, so that `save` and `restore` are possible at any.
    """

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
        east_m, north_m, _ = self._position().tolist()
        self.state = MowerState((east_m, north_m), "approach" if vehicle.released else "undock")
        self.lanes = self._lanes()

    @property
    def progress(self) -> float:
        """Share of the lanes' length that lies behind, 0..1."""
        lengths = [lane.length_m for lane in self.lanes]
        return min(1.0, (sum(lengths[: self.state.lane]) + self.state.along_m) / sum(lengths))

    def save(self) -> dict[str, Any]:
        """All that the way ahead depends on beside vehicle and clock, as JSON knows it."""
        peaks = [(x, y, z) for x, y, z in self.lookout.peaks_world_m.tolist()]
        return asdict(SavedMission(self.state, self.autopilot.sums, peaks))

    def restore(self, state: Mapping[str, Any]) -> None:
        """Take up what `save` gave; `run` then goes on from there. Raises ValueError."""
        saved = checked_state(SavedMission, state)
        self.state = saved.mower
        self.lanes = self._lanes()
        self.autopilot.sums = saved.autopilot
        self.lookout.remember(saved.lookout)

    def run(self) -> str:
        """Fly until the last lane ends (COVERED) or something else ends the mission; returns what did."""
        legs: dict[LegName, Callable[[LegStart], LegName]] = {
            "undock": self._undock,
            "approach": self._approach,
            "tilt": self._wait_for_tilt,
            "turn": self._turn,
            "abreast": self._go_abreast,
            "mow": self._mow,
        }
        state = self.state
        self.vehicle.sonar.aim(self._elevation_rad)
        try:
            if not self.vehicle.released:
                self.vehicle.release()
            while state.lane < len(self.lanes):
                if state.leg_start is None:
                    state.leg_start = self._leg_start()
                state.leg = legs[state.leg](state.leg_start)
                state.leg_start = None
        except StoppedError as stop:
            return str(stop)
        finally:
            self.vehicle.set_effort()
        return COVERED

    def _lanes(self) -> list[Lane]:
        near_m = np.array(self.state.lanes_near_m)
        return lawn_mower_lanes(self.plan.area_m, self.plan.line_spacing_m, self.plan.reach_m, near_m)

    @property
    def _elevation_rad(self) -> float:
        return -math.radians(self.plan.tilt_deg)

    def _back_to(self, start: LegStart) -> tuple[float, float]:
        """Velocity towards where the leg began."""
        x, y, _ = self._position().tolist()
        return 0.3 * (start.position_world_m[0] - x), 0.3 * (start.position_world_m[1] - y)

    def _leg_start(self) -> LegStart:
        x, y, z = self._position().tolist()
        self.state.furthest_m, self.state.furthest_s = 0.0, self.clock.time_s
        return LegStart(self.clock.time_s, (x, y, z), float(self.vehicle.pose.yaw_rad))

    # The legs: each flies from where it began until it is done, and names the next one.

    def _undock(self, start: LegStart) -> LegName:
        """Straight ahead and level until clear of the dock."""
        ahead = (UNDOCK_SPEED_M_S * math.cos(start.yaw_rad), UNDOCK_SPEED_M_S * math.sin(start.yaw_rad))
        while math.dist(self._position(), start.position_world_m) < UNDOCK_M:
            if self.clock.time_s > start.time_s + STUCK_AFTER_S:
                raise StoppedError("stuck in the station's dock")
            self._command(start.yaw_rad, ahead, start.position_world_m[2])
        return "approach"

    def _approach(self, start: LegStart) -> LegName:
        """To the first lane, facing it."""
        self._go_to(self.lanes[0].start_m, start, heading_rad=None)
        return "tilt"

    def _wait_for_tilt(self, start: LegStart) -> LegName:
        """On the spot, until the sonar's head points where it was told to, if it says where it does."""
        while abs(getattr(self.vehicle.sonar, "elevation_rad", self._elevation_rad) - self._elevation_rad) > TILT_RAD:
            if self.clock.time_s > start.time_s + STUCK_AFTER_S:
                break  # better a survey with another tilt than none
            self._steer(start.yaw_rad, self._back_to(start))
        return "turn"

    def _turn(self, start: LegStart) -> LegName:
        """Turn on the spot, a half turn, to port and to starboard by turns."""
        lane = self.lanes[self.state.lane]
        direction = 1.0 if self.state.lane % 2 == 0 else -1.0
        while abs(left := wrap_angle(lane.heading_rad - self.vehicle.pose.yaw_rad)) > math.radians(5.0):
            if self.clock.time_s > start.time_s + STUCK_AFTER_S:
                raise StoppedError(f"stuck in a turn, {math.degrees(left):.0f} degrees before its end")
            half_turn_ahead = abs(left) > math.radians(120.0)
            aside = self.vehicle.pose.yaw_rad + direction * math.radians(60.0)
            self._steer(aside if half_turn_ahead else lane.heading_rad, self._back_to(start))
        if self.state.lane > 0:
            self._require_room_to_port()
        return "abreast"

    def _require_room_to_port(self) -> None:
        """The published end: something near to port at a turn."""
        port_m = self.vehicle.sensors["proximity_port"].read()
        if port_m < TURN_RANGE_M:
            raise StoppedError(f"the proximity sensor reads {port_m:.1f} m at a turn")

    def _go_abreast(self, start: LegStart) -> LegName:
        """Side-step to the lane: to its start, or further on where the last lane was cut short."""
        lane = self.lanes[self.state.lane]
        along_m = _clip(lane.locate(np.array(start.position_world_m))[0], 0.0, lane.length_m)
        self._go_to(lane.start_m + along_m * lane.direction, start, lane.heading_rad)
        return "mow"

    def _mow(self, start: LegStart) -> LegName:
        """Forward along the lane while there is water ahead."""
        state, lane = self.state, self.lanes[self.state.lane]
        (ahead_x, ahead_y), speed = lane.direction.tolist(), self.plan.speed_m_s
        while True:
            along, across = lane.locate(self._position())
            state.along_m = _clip(along, 0.0, lane.length_m)
            if along >= lane.length_m or not self._water_ahead(self.vehicle.sonar.ping()):
                break
            if along > state.furthest_m + ARRIVED_M:
                state.furthest_m, state.furthest_s = along, self.clock.time_s
            elif self.clock.time_s > state.furthest_s + STUCK_AFTER_S:
                raise StoppedError(f"stuck {along:.0f} m into a lane")
            to_line = -0.5 * _clip(across, -2.0, 2.0)
            self._steer(lane.heading_rad, (speed * ahead_x - to_line * ahead_y, speed * ahead_y + to_line * ahead_x))
        state.lane, state.along_m = state.lane + 1, 0.0
        return "turn"

    def _water_ahead(self, ping: PingLike) -> bool:
        """The published rule: any of the first, the middle and the last beam reads more than 7 m."""
        ranges = ping.ranges_m
        return any(float(ranges[beam]) > TURN_RANGE_M for beam in (0, len(ranges) // 2, -1))

    def _go_to(self, point_m: NDArray[np.float64], start: LegStart, heading_rad: float | None) -> None:
        """To a point: facing it when no heading is given, else side-stepping with the heading held."""
        to_x, to_y = point_m.tolist()
        way_m = math.dist((to_x, to_y), start.position_world_m[:2])
        allowed_s = STUCK_AFTER_S + 5.0 * way_m / self.plan.speed_m_s
        while True:
            x, y, _ = self._position().tolist()
            distance = math.dist((to_x, to_y), (x, y))
            if distance <= ARRIVED_M:
                return
            if self.clock.time_s > start.time_s + allowed_s:
                raise StoppedError(f"stuck {distance:.0f} m before ({to_x:.0f}, {to_y:.0f}) m")
            heading = heading_rad if heading_rad is not None else math.atan2(to_y - y, to_x - x)
            speed = min(self.plan.speed_m_s, 0.2 + 0.3 * distance)
            if abs(wrap_angle(heading - self.vehicle.pose.yaw_rad)) > math.radians(30.0):
                speed = 0.0  # turn first, so that the sonar looks where the vehicle goes
            self._steer(heading, (speed * (to_x - x) / distance, speed * (to_y - y) / distance))

    # One control period.

    def _steer(self, heading_rad: float, velocity_world_m_s: tuple[float, float]) -> None:
        """At a safe height over what is known of the way."""
        pose = self.vehicle.pose
        position, yaw = pose.position_world_m, pose.yaw_rad
        height_m = float(position[2])
        self.lookout.see(self.vehicle.sonar.ping(), position, yaw)
        bed_m = height_m - self.vehicle.sensors["altitude"].read()
        wanted_m = max(bed_m, self.lookout.highest_m(position, yaw)) + self.plan.altitude_m
        target_m = min(wanted_m if math.isfinite(wanted_m) else height_m, SHALLOWEST_Z_M)
        # Slow down while the climb is still ahead.
        slower = _clip(1.0 - (target_m - height_m - 1.0) / 4.0, 0.1, 1.0)
        east_m_s, north_m_s = velocity_world_m_s
        self._command(heading_rad, (slower * east_m_s, slower * north_m_s), target_m)

    def _command(self, heading_rad: float, velocity_world_m_s: tuple[float, float], z_world_m: float) -> None:
        """While there is power."""
        if self.vehicle.telemetry().battery_percent <= 0.0:
            raise StoppedError("the battery is used up")
        if self.vehicle.pose.world_from_body[2, 2] < CAPSIZED_COSINE:
            raise StoppedError("capsized: the vehicle has nosed or rolled over")
        self.autopilot.steer(heading_rad, velocity_world_m_s, z_world_m)
        self.clock.wait(self.period_s)

    def _position(self) -> NDArray[np.float64]:
        return np.asarray(self.vehicle.pose.position_world_m, np.float64)


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)
