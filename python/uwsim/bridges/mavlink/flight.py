"""Arming, modes and missions of a MAVLink vehicle."""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace
from typing import Any

import numpy as np

from uwsim.bridges.actions import SUCCEEDED, Goal
from uwsim.bridges.actions.action import Plan, Route
from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.component import DONE, INFO_TEXT, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.missions import COMPLETE, PAUSED, MissionStore
from uwsim.bridges.mavlink.modes import (
    ALT_HOLD,
    AUTO,
    CUSTOM_MODE,
    GUIDED,
    HOLDS_OF,
    MANUAL,
    NAMES,
    POSHOLD,
    SURFACE,
    mode_of,
)
from uwsim.bridges.mavlink.plan import Ascent, MissionPlan
from uwsim.bridges.mavlink.servos import Servos
from uwsim.bridges.mavlink.stations import DISARM, HOLD_DEPTH, Sender, Stations
from uwsim.bridges.mavlink.stations import SURFACE as THEN_SURFACE
from uwsim.bridges.mavlink.telemetry import place
from uwsim.simulator.helm import Source


class Flight:
    """Arms the vehicle and sets its mode: manual flight with holds, or flight to targets or through a mission.

    Must be used on the bridge's thread, except for the methods that a flight calls to report its progress.
    """

    def __init__(self, craft: Craft, mission: MissionStore, servos: Servos, stations: Stations) -> None:
        self._craft, self._mission, self._servos, self._stations = craft, mission, servos, stations
        self.is_armed = False
        self._kept = MANUAL  # the mode while disarmed
        self._goal: Goal | None = None
        self._flies = MANUAL  # GUIDED, AUTO or SURFACE while the vehicle flies by itself
        self._target: Route | None = None
        self._is_steering = False  # at a velocity
        self._is_at_surface = False  # as a flight to it has found
        self._stop: Future[Any] | None = None

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD."""
        return {17: self._on_loiter, 21: self._on_land, 176: self._on_mode, 185: self._on_termination,
                224: self._on_set_current, 300: self._on_start, 400: self._on_arm}  # fmt: skip

    @property
    def mode(self) -> int:
        """The current mode, which depends on the flight in progress or else on the active holds."""
        if not self.is_armed:
            return self._kept
        if self._flies != MANUAL:
            return self._flies
        return mode_of(() if self._craft.state is None else self._craft.state.holds)

    @property
    def is_by_sticks(self) -> bool:
        """True if the sticks have an effect."""
        return self.is_armed and self._flies == MANUAL

    def _on_mode(self, given: Given) -> int:
        if not given.integer(1, 0, 255) & CUSTOM_MODE:  # as ArduPilot (GCS_Common.cpp, _set_mode_common)
            raise given.denied(1, f"with the flag of a custom mode ({CUSTOM_MODE})")
        self.set_mode(given.integer(2, 0, 2**32 - 1))
        return DONE

    def _on_loiter(self, given: Given) -> int:
        self.set_mode(POSHOLD)
        return DONE

    def _on_land(self, given: Given) -> int:
        self.set_mode(SURFACE)
        return DONE

    def _on_start(self, given: Given) -> int:
        last = max(len(self._mission.items) - 1, 0)
        for index, whole in ((1, (0, 1)), (2, (0, last))):  # the item at 0 is the home position
            if given.integer(index) not in whole:
                raise given.denied(index, f"{' or '.join(map(str, dict.fromkeys(whole)))}: the whole mission is flown")
        self.set_mode(AUTO)
        return DONE

    def _on_set_current(self, given: Given) -> int:
        self._set_current(given.integer(1, 0, max(len(self._mission.items) - 1, 0)))
        return DONE

    def on_mission_set_current(self, peer: Address, message: Any) -> None:
        """Fly an item of the mission next: at once in AUTO, else once it begins."""
        self._set_current(message.seq)

    def _set_current(self, number: int) -> None:
        self._mission.choose(number)
        if self._flies == AUTO:
            self.set_mode(AUTO)

    def _on_arm(self, given: Given) -> int:
        self.arm(given.sender) if given.switch(1) else self.disarm()
        return DONE

    def _on_termination(self, given: Given) -> int:
        on = given.switch(1)
        self.end()
        self._disarmed(MANUAL)
        begun, self._stop = self._stop if on else None, None
        self._craft.wait(begun or self._craft.begin("all_stop", on=on), "all_stop", is_stop=on)
        return DONE

    def stop_at_once(self) -> None:
        """Set all stop without waiting. The command that does so waits for the effect, and reports any error."""
        self._craft.interruptions += 1
        if self._stop is None or self._stop.done():
            with suppress(ValueError, RuntimeError):
                self._stop = self._craft.begin("all_stop", on=True)

    def arm(self, by: Sender) -> None:
        """Arm the vehicle, undocking it if necessary, in the mode kept. Raises ValueError while all stop is set.

        A mode in which the vehicle flies by itself only holds it: no flight goes on before it is commanded. by: the
        station, which owns the sticks from now on unless another has armed before.
        """
        if self.is_armed:
            return
        craft, vehicle = self._craft, self._craft.vehicle
        vehicle.helm.require("arm", Source.FAILSAFE)
        if not vehicle.released:
            craft.command("undock")
        self.is_armed = True
        self._stations.give_to(by)
        if craft.action is not None:  # the latest reading may be from before the undocking, which moves the vehicle
            mover = vehicle if craft.action.uses_truth else vehicle.start_navigation()
            craft.launch_world_m = mover.pose.position_world_m * np.array([1.0, 1.0, 0.0])
            craft.output.put(place(self._mission.mav, craft))
        if self._kept != MANUAL:
            try:
                self._begin(self._kept, None) if self._kept not in HOLDS_OF else self.set_mode(self._kept)
            except ValueError as error:
                craft.send_text(f"armed in MANUAL: {error}")

    def disarm(self) -> None:
        """Disarm: end the flight, the holds and the efforts. The mode is kept, for when it is armed again."""
        self._craft.interruptions += 1
        mode = self.mode
        self.end()
        self._disarmed(mode)
        self._craft.command("hold")
        self._craft.command("set_effort")

    def _disarmed(self, kept: int) -> None:
        self.is_armed, self._kept = False, kept
        self._stations.give_to(None)

    def require_armed(self, what: str) -> None:
        """Raise ValueError unless the vehicle is armed."""
        if not self.is_armed:
            raise ValueError(f"{what}: the vehicle is not armed")

    def set_mode(self, mode: int) -> None:
        """Change the mode. Raises ValueError."""
        if mode not in NAMES:
            raise ValueError(f"mode {mode}: must be one of {', '.join(f'{n} ({k})' for k, n in NAMES.items())}")
        if mode not in HOLDS_OF:
            self.require_armed(NAMES[mode])
            self._begin(mode, self._plan(mode))
            return
        if not self.is_armed:
            self._craft.require("hold")
            self._kept = mode
            return
        self._hold(*HOLDS_OF[mode])

    def _hold(self, *holds: str) -> None:
        """End the flight, whose last effort would count as the stick's, and replace the active holds."""
        was_flying = self._craft.is_flying
        self.end()
        if was_flying:
            self._craft.command("set_effort")
        self._craft.command("hold", **dict.fromkeys(holds, True))

    def _plan(self, mode: int) -> Plan | None:
        mission = self._mission
        if mode == AUTO:
            mission.require_within_fence()
            return MissionPlan(
                mission.items, mission.current, self._craft, self._servos, mission.begin, mission.reached
            )
        return Ascent() if mode == SURFACE else None

    def _begin(self, mode: int, plan: Plan | None) -> None:
        """Fly a plan or, without one, engage the holds that the vehicle supports."""
        action = self._craft.action
        if action is None:
            raise ValueError(f"{NAMES[mode]}: the vehicle has no estimate to fly by")
        if plan is None:
            holds = self._craft.vehicle.holds
            possible = [] if holds is None else holds.possible
            self._hold(*(hold for hold in ("heading", "depth", "position") if hold in possible))
        else:
            self.end()
            given = replace(action, route=lambda goal: goal, feedback=lambda progress: progress,
                            result=lambda elapsed_s, why: why)  # fmt: skip
            self._goal = goal = Goal(self._craft.live, given, plan, lambda progress: None,
                                     lambda status, why: self._ended(goal, mode, status, why))  # fmt: skip
            goal.start()
        self._flies = mode
        self._craft.is_flying = True

    def _ended(self, goal: Goal, mode: int, status: int, why: str) -> None:
        """Report the end of a flight, on its thread, unless another mode has ended it."""
        if goal is not self._goal:
            return
        if mode == AUTO:
            self._mission.end(COMPLETE if status == SUCCEEDED else PAUSED)
        if status == SUCCEEDED:
            self._is_at_surface = mode == SURFACE
            done = {AUTO: "Mission complete", SURFACE: "At the surface"}
            self._craft.send_text(done.get(mode, "Target reached"), INFO_TEXT)
        else:
            self._craft.send_text(f"{NAMES[mode]} ended: {why}")

    def end(self) -> Goal | None:
        """End the flight, if there is one, without waiting for its thread; return it."""
        goal, self._goal, self._target, self._flies = self._goal, None, None, MANUAL
        self._is_steering = self._is_at_surface = self._craft.is_flying = False
        if goal is not None:
            goal.leave()
            self._mission.end(PAUSED)
        return goal

    def fly_to(self, route: Route) -> None:
        """Fly to a target in GUIDED, unless the vehicle already does."""
        known = self._target
        if (
            known is None
            or abs(known.points_world_m - route.points_world_m).max() > 1e-3
            or (known.heading_rad, known.speed_m_s) != (route.heading_rad, route.speed_m_s)
        ):
            self._begin(GUIDED, route)
            self._target = route

    def begin_steering(self) -> None:
        """Make way for velocities in GUIDED: end the flight and the holds that keep the vehicle."""
        if not self._is_steering:
            self._hold()
            self._flies, self._is_steering, self._craft.is_flying = GUIDED, True, True

    def watch(self) -> None:
        """Change the mode where time does so: at the surface, and once the station that owns the sticks is silent."""
        if self._is_at_surface:
            self.set_mode(ALT_HOLD)
        if self.is_armed:
            action = self._stations.silent_action()
            if action == DISARM:
                self.disarm()
            elif action in (HOLD_DEPTH, THEN_SURFACE):
                self.set_mode(ALT_HOLD if action == HOLD_DEPTH else SURFACE)
