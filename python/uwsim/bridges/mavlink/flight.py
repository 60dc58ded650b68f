"""Arming, modes, targets and missions of a MAVLink vehicle."""

from __future__ import annotations

import math
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from uwsim.bridges.actions import SUCCEEDED, Goal
from uwsim.bridges.actions.action import Route
from uwsim.bridges.actions.table import SPEED_M_S
from uwsim.bridges.mavlink.component import DONE, UNSUPPORTED, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.earth import NED_FROM_ENU, Vector, euler_rad
from uwsim.bridges.mavlink.endpoint import Peer
from uwsim.bridges.mavlink.missions import FAR_M, SPEED_MAX_M_S, MissionStore, route_of
from uwsim.bridges.mavlink.modes import AUTO, GUIDED, HOLDS_OF, MANUAL, NAMES, mode_of
from uwsim.simulator.helm import Source

LOCAL, LOCAL_OFFSET, BODY_OFFSET = 1, 7, 9  # MAV_FRAME
GLOBAL_FRAMES = (0, 3, 5, 6, 11)
POSITION_IGNORED, YAW_IGNORED = 0b111, 1 << 10
RELATIVE_YAW = 2  # MAV_DO_REPOSITION_FLAGS
DEGREES_E7 = 1e-7
INFO = 6  # MAV_SEVERITY


class Flight:
    """Arms the vehicle and sets its mode: manual flight with holds, or flight to targets or through a mission.

    Must be used on the bridge's thread, except for the methods that a flight calls to report its progress.
    """

    def __init__(self, craft: Craft, mission: MissionStore) -> None:
        self._craft, self._mission = craft, mission
        self.is_armed = False
        self._goal: Goal | None = None
        self._flies = MANUAL  # GUIDED or AUTO while the vehicle flies by itself
        self._target: Route | None = None
        self._stop: Future[Any] | None = None

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD."""
        return {176: self._on_mode, 185: self._on_termination, 192: self._on_reposition, 300: self._on_start,
                400: self._on_arm}  # fmt: skip

    @property
    def mode(self) -> int:
        """The current mode, which depends on the flight in progress or else on the active holds."""
        if self._flies != MANUAL:
            return self._flies
        return mode_of(() if self._craft.state is None else self._craft.state.holds)

    @property
    def is_by_sticks(self) -> bool:
        """True if the sticks have an effect."""
        return self.is_armed and self._flies == MANUAL

    def _on_mode(self, given: Given) -> int:
        given.integer(1, 0, 255)  # MAV_MODE_FLAG
        self.set_mode(given.integer(2, 0, 2**32 - 1))
        return DONE

    def _on_start(self, given: Given) -> int:
        last = max(len(self._mission.items) - 1, 0)
        for index, whole in ((1, (0, 1)), (2, (0, last))):  # the item at 0 is the home position
            if given.integer(index) not in whole:
                raise given.denied(index, f"{' or '.join(map(str, dict.fromkeys(whole)))}: the whole mission is flown")
        self.set_mode(AUTO)
        return DONE

    def _on_arm(self, given: Given) -> int:
        self.arm() if given.switch(1) else self.disarm()
        return DONE

    def _on_termination(self, given: Given) -> int:
        on = given.switch(1)
        self.end()
        self.is_armed = False
        begun, self._stop = self._stop if on else None, None
        self._craft.wait(begun or self._craft.begin("all_stop", on=on), "all_stop", is_stop=on)
        return DONE

    def stop_at_once(self) -> None:
        """Set all stop without waiting. The command that does so waits for the effect, and reports any error."""
        self._craft.interruptions += 1
        if self._stop is None or self._stop.done():
            with suppress(ValueError, RuntimeError):
                self._stop = self._craft.begin("all_stop", on=True)

    def _on_reposition(self, given: Given) -> int:
        if given.frame not in GLOBAL_FRAMES:
            return UNSUPPORTED
        speed_m_s, yaw = given.real(1, may_be_nan=True), given.real(4, may_be_nan=True)
        is_default = math.isnan(speed_m_s) or speed_m_s in (-1, 0)
        if not (is_default or 0 < speed_m_s <= SPEED_MAX_M_S):
            raise given.denied(1, f"a speed in (0, {SPEED_MAX_M_S:g}] m/s, or -1 for the default")
        turns = math.isfinite(yaw) and yaw != 0
        if given.integer(2, 0, 255) & RELATIVE_YAW and turns:
            raise given.denied(2, "without the flag of a relative yaw (2)")
        lat_deg, lon_deg = (DEGREES_E7 * given.real(index) for index in (5, 6))
        point = self._craft.home.world_m(lat_deg, lon_deg, given.real(7))
        self._require_armed("target")
        self._fly_to(point, math.pi / 2 - yaw if turns else None, SPEED_M_S if is_default else speed_m_s)
        return DONE

    def arm(self) -> None:
        """Arm the vehicle, undocking it if necessary. Raises ValueError while all stop is set."""
        vehicle = self._craft.vehicle
        vehicle.helm.require("arm", Source.FAILSAFE)
        if not vehicle.released:
            self._craft.command("undock")
        self.is_armed = True

    def disarm(self) -> None:
        """Disarm: end the flight, the holds and the efforts."""
        self._craft.interruptions += 1
        self.end()
        self.is_armed = False
        self._craft.command("hold")
        self._craft.command("set_effort")

    def _require_armed(self, what: str) -> None:
        if not self.is_armed:
            raise ValueError(f"{what}: the vehicle is not armed")

    def on_set_mode(self, peer: Peer, message: Any) -> None:
        """Change the mode."""
        self.set_mode(message.custom_mode)

    def set_mode(self, mode: int) -> None:
        """Change the mode. Raises ValueError."""
        if mode not in NAMES:
            raise ValueError(f"mode {mode}: must be one of {', '.join(f'{n} ({k})' for k, n in NAMES.items())}")
        if mode in (AUTO, GUIDED):
            self._require_armed(NAMES[mode])
            self._begin(mode, route_of(self._mission.items, self._craft.home)[0] if mode == AUTO else None)
            return
        self.end()
        self._craft.command("hold", **dict.fromkeys(HOLDS_OF[mode], True))

    def _begin(self, mode: int, route: Route | None) -> None:
        """Fly a route or, in GUIDED without a target, engage the holds that the vehicle supports."""
        action = self._craft.action
        if action is None:
            raise ValueError(f"{NAMES[mode]}: the vehicle has no estimate to fly by")
        self.end()
        if route is None:
            holds = self._craft.vehicle.holds
            possible = [] if holds is None else holds.possible
            self._craft.command("hold", **{hold: True for hold in ("heading", "depth", "position") if hold in possible})
        else:
            given = replace(action, route=lambda goal: goal, feedback=lambda progress: progress,
                            result=lambda elapsed_s, why: why)  # fmt: skip
            numbers = route_of(self._mission.items, self._craft.home)[1] if mode == AUTO else []
            goal = Goal(self._craft.live, given, route, lambda progress: self._mission.report(numbers, progress.leg),
                        lambda status, why: self._ended(goal, numbers, status, why))  # fmt: skip
            goal.start()
            self._goal, self._target = goal, route
        self._flies = mode

    def _ended(self, goal: Goal, numbers: list[int], status: int, why: str) -> None:
        if status == SUCCEEDED:
            self._mission.report_reached(numbers)
            self._craft.send_text("Mission complete" if numbers else "Target reached")
        elif goal is self._goal:
            self._craft.send_text(f"{NAMES[self._flies]} ended: {why}")

    def end(self) -> None:
        """End the flight, if there is one."""
        goal, self._goal, self._target, self._flies = self._goal, None, None, MANUAL
        if goal is not None:
            goal.close()

    def on_set_position_target_local_ned(self, peer: Peer, message: Any) -> None:
        """Fly to a position in GUIDED, relative to the origin or to the vehicle (along the world's axes or its own)."""
        frame, offset = message.coordinate_frame, np.array([message.x, message.y, message.z])
        if frame not in (LOCAL, LOCAL_OFFSET, BODY_OFFSET):
            raise ValueError(
                f"target: frame {frame}: must be local NED (1), or an offset along NED (7) or the body (9)"
            )
        if not np.isfinite(offset).all():
            raise ValueError(f"target = {offset.tolist()} m: must be numbers")
        if frame == LOCAL:
            self._guide(message, NED_FROM_ENU.T @ offset)
            return
        state = self._craft.state
        if state is None:
            raise ValueError("target: the vehicle's position is not known yet")
        if frame == BODY_OFFSET:
            yaw = euler_rad(state.world_from_body)[2]
            forward, right = offset[:2]
            offset[0] = math.cos(yaw) * forward - math.sin(yaw) * right
            offset[1] = math.sin(yaw) * forward + math.cos(yaw) * right
        self._guide(message, state.position_world_m + NED_FROM_ENU.T @ offset)

    def on_set_position_target_global_int(self, peer: Peer, message: Any) -> None:
        """Fly to a geographic location in GUIDED."""
        if message.coordinate_frame not in GLOBAL_FRAMES:
            raise ValueError(f"target: frame {message.coordinate_frame}: must be a global one (0, 3, 5, 6, 11)")
        place = DEGREES_E7 * message.lat_int, DEGREES_E7 * message.lon_int
        self._guide(message, self._craft.home.world_m(*place, message.alt))

    def _guide(self, message: Any, point: Vector) -> None:
        self._require_armed("target")
        if self._flies != GUIDED:
            raise ValueError("target: must be in mode GUIDED")
        if message.type_mask & POSITION_IGNORED:
            raise ValueError("target: only positions are supported, not velocities or accelerations")
        self._fly_to(point, None if message.type_mask & YAW_IGNORED else math.pi / 2 - message.yaw)

    def _fly_to(self, point: Vector, heading_rad: float | None, speed_m_s: float = SPEED_M_S) -> None:
        if not (all(math.isfinite(part) and abs(part) < FAR_M for part in point) and point[2] <= 0):
            raise ValueError(
                f"target = {[round(float(part), 2) for part in point]} m: must be near, and not above water"
            )
        if heading_rad is not None and not math.isfinite(heading_rad):
            raise ValueError("target: yaw: must be a number")
        route = Route(point.reshape(1, 3), speed_m_s, heading_rad)
        known = self._target
        if (
            known is None
            or abs(known.points_world_m - route.points_world_m).max() > 1e-3
            or (known.heading_rad, known.speed_m_s) != (heading_rad, speed_m_s)
        ):
            self._begin(GUIDED, route)
