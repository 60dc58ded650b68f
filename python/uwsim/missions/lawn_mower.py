"""The seed paper's adaptive lawn-mower over a polygon, using only a vehicle's public interface.

As published: release; go to the start; go forward while any of the first, middle and last beams reads more than 7 m;
turn by 180 degrees; side-step; repeat, turning the other way each time; stop when the proximity sensor reads less than
7 m at a turn. This version adds the polygon (a lane ends at its edge, and the mission after the last lane), stays at a
height above the bed and above obstacles that the sonar sees ahead, and goes around shoals too high to pass over. Near
the bed, where all ranges are short, 7 m give way to what the geometry leaves (`water_ahead.py`). What was flown of each
lane is compared with its length, and a survey of which less than 95 % was flown is not complete. A vehicle that cannot
go sideways flies from lane to lane in curves (`lane_curves.py`), without stopping; one that slips in them and can hover
stops, turns and goes ahead to the next lane. It can serve as a template for other missions.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from itertools import accumulate
from types import MappingProxyType
from typing import cast

import numpy as np
from numpy.typing import NDArray

from uwsim.base.sealed import Sealed
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.lane_curves import LaneCurves, LegName, LegStart, MowerState, is_under_way, slips
from uwsim.missions.lanes import LANE_FLOWN, LANES_FLOWN, LEAST_FLOWN, Lane, LaneEnd, lane_values, not_flown_because
from uwsim.missions.lawn_mower_plan import LawnMowerPlan, SlowPlanWarning, missing_for_lanes
from uwsim.missions.lookout import Lookout
from uwsim.missions.own_vehicle import OwnVehicle, own_vehicle
from uwsim.missions.steps import Steps, StoppedError, drive, is_at
from uwsim.missions.vehicle import Vehicle
from uwsim.missions.water_ahead import TURN_RANGE_M, is_water_ahead
from uwsim.navigation.control.autopilot import wrap_angle
from uwsim.navigation.control.controller import Pilot, survey_pilot
from uwsim.navigation.control.protocols import Clock, SurveyVehicle, Watch
from uwsim.navigation.sensor_choice import port_proximity

COVERED = "all lanes are flown"  # the result of run() if nothing stopped the mission
BESIDE_M = 2.0  # what the published 7 m to port leave beside its steps of 5 m
UNDOCK_M, UNDOCK_SPEED_M_S = 6.0, 0.5
ARRIVED_M, ARRIVED_AHEAD_M = 0.5, 1.0  # a point counts as reached within this distance
PASSABLE_Z_M = HIGHEST_Z_M - 2.0  # anything higher is a shoal, which the vehicle avoids
HALF_WIDTH_M = 3.0  # half the width of the corridor ahead in which the vehicle climbs over obstacles
LOOK_AHEAD_M = 6.0  # a lane ends this far in front of a shoal
SIDE_STEPS = 3.0  # in line spacings; a lane farther away is reached by a transit, facing the direction of travel
STUCK_AFTER_S, TURN_FIRST_RAD = 60.0, math.radians(30.0)
STOPPED_M, STOPPED_AFTER_S = 3.0, 30.0  # a vehicle that slips is taken to be carried by a current after that
MOST_LEGS = 12  # for one lane, of a vehicle that flies curves


class AdaptiveLawnMower(Sealed):
    """Flies a survey plan, given a vehicle and a clock as defined in `navigation/control/protocols.py`.

    `run` needs a clock that can wait. The legs are "undock", "approach" and "tilt", then "turn", "abreast" and "mow"
    for each lane; a distant lane is preceded by a "transit" and another "tilt". During a long transit the sonar looks
    farther ahead than on the lanes. Without sway there are only "undock", "turn" (a curve), "transit" (around shoals)
    and "mow"; after a curve in which it slipped, each lane is preceded by a "transit", "tilt" and "turn". `state` is
    its progress.
    """

    vehicle: SurveyVehicle
    clock: Watch
    plan: LawnMowerPlan
    period_s: float
    autopilot: Pilot
    lookout: Lookout
    _fixed_when = "the mission is made"
    _changed_by = MappingProxyType({"lanes": "the plan's lanes"})

    def __init__(self, vehicle: SurveyVehicle, clock: Watch, plan: LawnMowerPlan, period_s: float = 0.1) -> None:
        if missing := missing_for_lanes(vehicle, plan.altitude_m):
            raise ValueError(f"the vehicle cannot fly lanes: {'; '.join(missing.values())}")
        self.vehicle = vehicle
        self.clock = clock
        self.plan = plan
        self.period_s = period_s
        self.autopilot = survey_pilot(vehicle, period_s)
        self._own = vehicle if isinstance(vehicle, OwnVehicle) else OwnVehicle(vehicle, clock)
        self.lookout = Lookout(
            self._own, plan.altitude_m, half_width_m=HALF_WIDTH_M, ahead_m=max(20.0, 1.3 * plan.transit_view_m),
            passable_z_m=PASSABLE_Z_M, turn_first_rad=TURN_FIRST_RAD, most_climb_m=math.inf, autopilot=self.autopilot,
            yoyo=plan.yoyo,
        )  # fmt: skip
        self._drives_sway = "sway" in self._own.controllable
        least_m_s = float(getattr(self._own.control, "speed_min_m_s", 0.0))
        self._speed_m_s = max(plan.speed_m_s, least_m_s)
        self._curves = LaneCurves(self.lookout, clock, self._speed_m_s, hovers=least_m_s == 0.0, least_m_s=least_m_s)
        if self._speed_m_s > plan.speed_m_s:
            text = f"the plan's speed, {plan.speed_m_s:g} m/s, is too slow for the vehicle's fins: it flies at "
            warnings.warn(f"{text}{self._speed_m_s:g} m/s", SlowPlanWarning, stacklevel=2)
        self._state = MowerState("approach" if vehicle.released else "undock")
        self._lanes = plan.lanes_near(self._position()[:2]) if plan.lanes is None else list(plan.lanes)
        self._length_before_m = [0.0, *accumulate(lane.length_m for lane in self._lanes)]

    def __repr__(self) -> str:
        return f"<AdaptiveLawnMower of {self.vehicle!r}: lane {self._state.lane}, {self._state.leg}>"

    @property
    def state(self) -> MowerState:
        """The mission's progress."""
        return self._state

    @property
    def lanes(self) -> list[Lane]:
        """The lanes in flight order."""
        return self._lanes

    @property
    def progress(self) -> float:
        """Fraction of the plan's length that is behind the vehicle, flown or not, 0..1."""
        return min(1.0, (self._length_before_m[self.state.lane] + self.state.along_m) / self._length_before_m[-1])

    @property
    def flown_m(self) -> list[float]:
        """How much was flown of each lane so far, in flight order."""
        ended = [end.flown_m for end in self.state.ended]
        return [*ended, self._flown_of_lane_m(), *[0.0] * len(self.lanes)][: len(self.lanes)]

    def run(self) -> str:
        """Fly until the last lane ends or the mission stops early; return the reason, COVERED if 95 % was flown."""
        if not hasattr(self.clock, "wait"):
            raise ValueError("run: the clock cannot wait: use `yield from mower.steps()`")
        return drive(self.steps(), cast(Clock, self.clock))

    def steps(self) -> Steps[str]:
        """Return the mission as steps; `ended = yield from mower.steps()` is equivalent to `run`."""
        state = self.state
        try:
            if not self.vehicle.released:
                self.vehicle.release()
            while state.lane < len(self.lanes):
                start = self._leg_start()
                self.vehicle.sonar.aim(-math.radians(self.plan.tilt_deg))
                state.leg = yield from self._legs()[state.leg](start)
        except StoppedError as stop:
            return str(stop)
        finally:
            self.vehicle.set_effort()
            self._log_lanes()
        if state.skipped:
            return f"no way led to {state.skipped} of {len(self.lanes)} lanes"
        planned_m, flown_m = self._length_before_m[-1], sum(self.flown_m)
        return COVERED if flown_m >= LEAST_FLOWN * planned_m else not_flown_because(flown_m, planned_m, state.ended)

    def _legs(self) -> dict[LegName, Callable[[LegStart], Steps[LegName]]]:
        legs: dict[LegName, Callable[[LegStart], Steps[LegName]]] = {
            "undock": self._undock,
            "approach": self._approach,
            "transit": self._transit,
            "tilt": self._wait_for_tilt,
            "turn": self._turn,
            "abreast": self._side_step,
            "mow": self._mow,
        }
        if self._drives_sway:
            return legs
        if self.state.stops:
            return legs | {"approach": self._stop, "transit": self._stop, "abreast": self._come_abreast}
        curve, around = self._curve, self._around
        return legs | {"approach": curve, "tilt": curve, "turn": curve, "abreast": curve, "transit": around}

    def _look_farther_ahead(self) -> None:
        """Tilt the sonar less than on the lanes, so that its fan hits a flat bed farther ahead."""
        tilt_rad = math.atan2(self.plan.altitude_m, self.plan.transit_view_m)
        elevation_rad = -min(tilt_rad, math.radians(self.plan.tilt_deg))
        if getattr(self.vehicle.sonar, "target_elevation_rad", None) != elevation_rad:
            self.vehicle.sonar.aim(elevation_rad)

    def _back_to(self, start: LegStart) -> tuple[float, float]:
        """Return a horizontal velocity back towards the position where the leg began."""
        x, y, _ = self._position().tolist()
        return 0.3 * (start.position_world_m[0] - x), 0.3 * (start.position_world_m[1] - y)

    def _leg_start(self) -> LegStart:
        x, y, z = self._position().tolist()
        state = self.state
        state.furthest_m, state.furthest_s, state.reached, state.legs = 0.0, self.clock.time_s, 0, state.legs + 1
        return LegStart(self.clock.time_s, (x, y, z), float(self.vehicle.pose.yaw_rad))

    # The legs: each flies until it is complete and returns the name of the next one.

    def _undock(self, start: LegStart) -> Steps[LegName]:
        """Go straight ahead at constant height until clear of the dock."""
        ahead = (UNDOCK_SPEED_M_S * math.cos(start.yaw_rad), UNDOCK_SPEED_M_S * math.sin(start.yaw_rad))
        while math.dist(self._position(), start.position_world_m) < UNDOCK_M:
            if self.clock.time_s > start.time_s + STUCK_AFTER_S:
                raise StoppedError("stuck in the station's dock")
            yield from self.lookout.steer_at(start.yaw_rad, ahead, start.position_world_m[2])
        return "approach"

    def _approach(self, start: LegStart) -> Steps[LegName]:
        """Travel to the first lane, facing it."""
        if not (yield from self._go_to(self.lanes[self.state.lane].start_m, start, heading_rad=None)):
            return self._skip_lane("approach")
        return "tilt"

    def _skip_lane(self, leg: LegName) -> LegName:
        """Skip a lane that shoals make unreachable, and return the leg that leads to the next one."""
        self._end_lane("no way led to it")
        self.state.skipped += 1
        return leg

    def _end_lane(self, because: str) -> None:
        """Note how much of the lane was flown and why no more, and begin with the next one."""
        state = self.state
        end = LaneEnd(self._flown_of_lane_m(), because or ("begun past its start" if state.entry_m else ""))
        self._log_lane(end)
        state.ended.append(end)
        state.lane, state.along_m, state.legs, state.entry_m = state.lane + 1, 0.0, 0, None

    def _flown_of_lane_m(self) -> float:
        entry_m = self.state.entry_m
        return 0.0 if entry_m is None else max(self.state.along_m - entry_m, 0.0)

    def _log_lane(self, end: LaneEnd) -> None:
        number = self.state.lane
        self._own.log(LANE_FLOWN, **lane_values(number, self.lanes[number].length_m, end))

    def _log_lanes(self) -> None:
        """Log how much was flown of the lane that the end interrupts, if any, and of all lanes."""
        if self.state.entry_m is not None:
            self._log_lane(LaneEnd(self._flown_of_lane_m(), "the mission ended"))
        flown_m, planned_m = round(sum(self.flown_m), 2), round(self._length_before_m[-1], 2)
        self._own.log(LANES_FLOWN, lanes=len(self.lanes), flown_m=flown_m, planned_m=planned_m)

    def _wait_for_tilt(self, start: LegStart) -> Steps[LegName]:
        """Wait on the spot until the sonar head reaches its elevation, provided that the sonar reports it."""
        target_rad = -math.radians(self.plan.tilt_deg)
        while not is_at(self.vehicle.sonar, target_rad):
            if self.clock.time_s > start.time_s + STUCK_AFTER_S:
                break  # a survey with a different tilt is better than none
            yield from self.lookout.steer(start.yaw_rad, self._back_to(start))
        return "turn"

    def _turn(self, start: LegStart) -> Steps[LegName]:
        """Turn on the spot to the lane heading; half turns alternate between port and starboard."""
        lane = self.lanes[self.state.lane]
        direction = 1.0 if self.state.lane % 2 == 0 else -1.0
        while abs(left := wrap_angle(lane.heading_rad - self.vehicle.pose.yaw_rad)) > math.radians(5.0):
            if self.clock.time_s > start.time_s + STUCK_AFTER_S:
                raise StoppedError(f"stuck in a turn, {math.degrees(left):.0f} degrees before its end")
            half_turn_ahead = abs(left) > math.radians(120.0)
            aside = self.vehicle.pose.yaw_rad + direction * math.radians(60.0)
            back = self._back_to(start) if self._drives_sway else (0.0, 0.0)
            yield from self.lookout.steer(aside if half_turn_ahead else lane.heading_rad, back)
        if self.state.lane > 0:
            self._require_clearance_to_port(lane)
        return "abreast"

    def _require_clearance_to_port(self, lane: Lane) -> None:
        """Stop, as published, within 7 m of something to port, or BESIDE_M beyond the lane; only if that is to port."""
        sensor, to_port_m = port_proximity(self.vehicle.sensors), -lane.locate(self._position())[1]
        if sensor is None or to_port_m <= 0.0:
            return
        if (port_m := sensor.read()) < min(TURN_RANGE_M, to_port_m + BESIDE_M):
            raise StoppedError(f"the proximity sensor reads {port_m:.1f} m at a turn, {to_port_m:.1f} m from a lane")

    def _side_step(self, start: LegStart) -> Steps[LegName]:
        """Side-step to the start of the lane, or to a point further along it if the last lane was cut short."""
        point_m = self._nearest_on_lane(start)
        if math.dist(point_m, start.position_world_m[:2]) > SIDE_STEPS * self.plan.line_spacing_m:
            return "transit"
        if not (yield from self._go_to(point_m, start, self.lanes[self.state.lane].heading_rad)):
            return self._skip_lane("turn")
        return "mow"

    def _transit(self, start: LegStart) -> Steps[LegName]:
        """Travel to a distant lane, facing the direction of travel."""
        if not (yield from self._go_to(self._nearest_on_lane(start), start, heading_rad=None)):
            return self._skip_lane("tilt")
        return "tilt"

    def _nearest_on_lane(self, start: LegStart) -> NDArray[np.float64]:
        """Return the point on the lane nearest to the position where the leg began; of a cross line, its start."""
        number = self.state.lane
        lane = self.lanes[number]
        if number and abs(float(lane.direction @ self.lanes[number - 1].direction)) < 0.5:
            return lane.start_m
        along_m = _clip(lane.locate(np.array(start.position_world_m))[0], 0.0, lane.length_m)
        return lane.start_m + along_m * lane.direction

    def _curve(self, start: LegStart) -> Steps[LegName]:
        """Fly a curve onto the lane's line, or further along it if the last lane was cut short; wider if it missed."""
        lane, entry_m = self._entry(start)
        ended = yield from self._curves.onto(lane, entry_m, start, self.state)
        if ended == "slipped":
            self.state.stops = True
            self._own.log("stops_to_turn", lane=self.state.lane)
            return "transit"
        if self.state.legs > MOST_LEGS:
            return self._skip_lane("turn")
        return "mow" if ended == "entered" else "transit" if ended == "blocked" else "turn"

    def _stop(self, start: LegStart) -> Steps[LegName]:
        """Stop, and travel to the lane, facing the direction of travel."""
        while is_under_way(self.vehicle) and self.clock.time_s < start.time_s + STOPPED_AFTER_S:
            yield from self.lookout.steer(start.yaw_rad, (0.0, 0.0))
        _, entry_m = self._entry(self._leg_start_here(start))
        if not (yield from self._go_to(entry_m, start, heading_rad=None)):
            return self._skip_lane("abreast")
        return "tilt"

    def _come_abreast(self, start: LegStart) -> Steps[LegName]:
        """Fly along the lane from a place on it, and travel to it from elsewhere."""
        lane = self.lanes[self.state.lane]
        along_m, across_m = lane.locate(np.array(start.position_world_m))
        if abs(across_m) <= STOPPED_M and -STOPPED_M <= along_m <= lane.length_m:
            return "mow"
        return self._skip_lane("abreast") if self.state.legs > MOST_LEGS else "transit"
        yield  # a leg is a generator

    def _leg_start_here(self, start: LegStart) -> LegStart:
        x, y, z = self._position().tolist()
        return LegStart(start.time_s, (x, y, z), start.yaw_rad)

    def _around(self, start: LegStart) -> Steps[LegName]:
        """Fly around the shoals that are in the way of a curve."""
        _, entry_m = self._entry(start)
        found = yield from self._curves.around((float(entry_m[0]), float(entry_m[1])), start)
        return "turn" if found else self._skip_lane("turn")

    def _entry(self, start: LegStart) -> tuple[Lane, NDArray[np.float64]]:
        lane = self.lanes[self.state.lane]
        return lane, self._nearest_on_lane(start) if self.state.lane > 0 else lane.start_m

    def _mow(self, start: LegStart) -> Steps[LegName]:
        """Move forward along the lane as long as there is water ahead."""
        state, lane = self.state, self.lanes[self.state.lane]
        (ahead_x, ahead_y), speed = lane.direction.tolist(), self._speed_m_s
        if state.entry_m is None:
            along = lane.locate(self._position())[0]
            state.entry_m = along if along > ARRIVED_M else 0.0
        while (because := self._end_of_lane(lane)) is None:
            along, across = lane.locate(self._position())
            if along > state.furthest_m + ARRIVED_M:
                state.furthest_m, state.furthest_s = along, self.clock.time_s
            elif self.clock.time_s > state.furthest_s + STUCK_AFTER_S:
                raise StoppedError(f"stuck {along:.0f} m into a lane")
            if state.stops:
                yield from self._curves.hold(lane, state)
                continue
            if not self._drives_sway:
                yield from self._curves.make_for(lane.point(along + self._curves.ahead_m))
                continue
            port_m_s = -0.5 * _clip(across, -2.0, 2.0)  # steers back to the line
            velocity = (speed * ahead_x - port_m_s * ahead_y, speed * ahead_y + port_m_s * ahead_x)
            yield from self.lookout.steer(lane.heading_rad, velocity)
        self._end_lane(because)
        return "abreast" if self.state.stops else "turn"

    def _end_of_lane(self, lane: Lane) -> str | None:
        """Return why the vehicle flies no farther along the lane, "" at its end; None if it goes on."""
        position = self._position()
        along = lane.locate(position)[0]
        self.state.along_m = _clip(along, 0.0, lane.length_m)
        if along >= lane.length_m:
            return ""
        # a vehicle that flies curves pitches, so that its beams look elsewhere; it turns before shoals
        if self._drives_sway and not is_water_ahead(self.vehicle.sonar.ping(), self.lookout.bed_z_m):
            return "no water ahead"
        return "a shoal ahead" if self._shoal_ahead(position, lane) else None

    def _shoal_ahead(self, position: NDArray[np.float64], lane: Lane) -> bool:
        x, y, _ = position.tolist()
        ahead_x, ahead_y = lane.direction.tolist()
        look_m = max(LOOK_AHEAD_M, self.state.radius_m + HALF_WIDTH_M)  # a vehicle that flies curves cannot stop
        return self.lookout.shoals.blocks((x, y), (x + look_m * ahead_x, y + look_m * ahead_y))

    def _go_to(self, point_m: NDArray[np.float64], start: LegStart, heading_rad: float | None) -> Steps[bool]:
        """Travel to a point, going around shoals; return False if there is no path.

        On a long transit the sonar looks farther ahead. If heading_rad is set, the vehicle holds that heading as long
        as the path is straight; otherwise it faces the direction of travel.
        """
        to_x, to_y = point_m.tolist()
        total_m = math.dist((to_x, to_y), start.position_world_m[:2])
        if heading_rad is None and total_m > self.plan.transit_view_m:
            self._look_farther_ahead()
        allowed_s = STUCK_AFTER_S + 5.0 * total_m / self.plan.speed_m_s
        while True:
            x, y, _ = self._position().tolist()
            distance = math.dist((to_x, to_y), (x, y))
            if distance <= (ARRIVED_M if self._drives_sway else ARRIVED_AHEAD_M):
                return True
            if (aim := self.lookout.shoals.next_point((x, y), (to_x, to_y))) is None:
                return False
            straight = aim == (to_x, to_y)
            if self.clock.time_s > start.time_s + allowed_s:
                if not straight:
                    return False  # a long search along shoals has failed
                raise StoppedError(f"stuck {distance:.0f} m before ({to_x:.0f}, {to_y:.0f}) m")
            speed_m_s = min(self.plan.speed_m_s, 0.2 + 0.3 * distance)
            if not self._drives_sway:  # until its side slip has died down, it would circle about the point
                speed_m_s = 0.0 if slips(self.vehicle) else min(speed_m_s, 0.1 + 0.1 * distance)
            yield from self.lookout.head_for(aim, speed_m_s, heading_rad if straight else None)

    def _position(self) -> NDArray[np.float64]:
        return self.vehicle.pose.position_world_m


def _clip(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def mow(vehicle: Vehicle, plan: LawnMowerPlan) -> Steps[None]:
    """Fly the lanes of a plan with the adaptive lawn-mower. Raises StoppedError unless all lanes are flown."""
    own = own_vehicle(vehicle)
    ended = yield from AdaptiveLawnMower(own, own, plan).steps()
    if ended != COVERED:
        raise StoppedError(ended)
