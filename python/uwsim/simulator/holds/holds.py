"""Holds of one vehicle: each maintains the value measured when the stick was let go, and yields to the stick."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from uwsim.base.agenda import NEVER, Agenda, Rank
from uwsim.base.axes import AXES
from uwsim.base.commands.holds import EXCLUSIVE, HOLDS
from uwsim.navigation.control.controller import Controller
from uwsim.simulator.failures.events import EventLog
from uwsim.simulator.failures.steered import ZERO, Aided
from uwsim.simulator.helm import Reason
from uwsim.simulator.holds.listener import COMPASS, EVERY_HOLD, HoldsState, Listener
from uwsim.simulator.vehicle import Vehicle

PERIOD_S = 0.05  # period of the control loop
LEVEL = ("roll", "pitch")  # axes that every hold keeps level
BRAKING_S = 5.0  # longest time between letting go of the stick and holding
AT_REST = {"heading": 0.03, "depth": 0.03, "altitude": 0.03, "position": 0.05, "speed": math.inf}
"""The rate [rad/s or m/s] below which the vehicle counts as at rest, so that the target is set."""
MISSES = ("dvl",)  # kinds of sensor that occasionally miss a reading
HEAVE_INTEGRAL, YAW_INTEGRAL, VELOCITY, TURN = 2, 5, 6, 9  # indices into Controller.memory


class Holds:
    """The holds of one vehicle; docs/guides/holds.md states their rules. They act only while the vehicle is released.

    targets: the target of each active hold: yaw [rad], z for the depth [m], altitude [m], x and y [m], speed ahead
    [m/s]; None while the stick moves the vehicle or the vehicle comes to rest. note: why the last hold was lost or
    changed; "" if none has been.
    """

    def __init__(self, vehicle: Vehicle, *, agenda: Agenda, events: EventLog, step_s: float) -> None:
        self._vehicle = vehicle
        self._agenda = agenda
        self._events = events
        self._period_ticks = max(1, round(PERIOD_S / step_s))
        self._listener = Listener(vehicle, PERIOD_S)
        self._aided = Aided(vehicle)
        self.restart()

    def restart(self) -> None:
        """Return to the state at the start of a run."""
        self.targets: dict[str, list[float] | None] = {}
        self._braking: dict[str, int] = {}
        self.note = ""
        self._listener.silent = {}
        self._pilot: Controller | None = None
        self._aided.stick = self._aided.last = ZERO
        self._aided.held = frozenset()
        self._attend(NEVER)

    def _attend(self, due_tick: int) -> None:
        self.due_tick = due_tick
        if due_tick == NEVER:
            self._agenda.remove(self)
        elif self not in self._agenda:
            self._agenda.add(self, Rank.HOLD, self.act)

    @property
    def has_control(self) -> bool:
        """True while any hold is active."""
        return bool(self.targets)

    def set(self, **on: bool) -> None:
        """Activate exactly these holds; those already active keep their targets. Raises ValueError."""
        names = [name for name in HOLDS if on.get(name)]
        self._require(names)
        self._vehicle.helm.note_command()
        self.note = ""
        if not names:
            self._end_all("")
            return
        _ = self._vehicle.navigation.steering
        tick = self._agenda.tick
        if not self.targets:
            self._aided.stick = tuple(self._vehicle.effort.tolist())
            self._pilot = None
        self._braking = {name: self._braking.get(name, tick) for name in names}
        self.targets = {name: self.targets.get(name) for name in names}
        self._vehicle.helm.is_driven = True
        self._attend(tick)

    def aim(self, heading_rad: float | None = None, z_world_m: float | None = None) -> None:
        """Give the active heading and depth hold a target, until the stick moves the vehicle. Raises ValueError."""
        given = {"heading": heading_rad, "depth": z_world_m}
        for name, value in given.items():
            if value is not None and name not in self.targets:
                raise ValueError(f"vehicle '{self._vehicle.name}': hold_at: {name} is not held: hold it first")
        self._vehicle.helm.note_command()
        self.targets |= {name: [float(value)] for name, value in given.items() if value is not None}

    @property
    def possible(self) -> list[str]:
        """The names of the holds for which the vehicle has actuators and sensors."""
        return [name for name in HOLDS if not self._listener.lack(name)]

    def _require(self, names: Sequence[str]) -> None:
        """Raise ValueError unless these holds may be active."""
        where = f"vehicle '{self._vehicle.name}': hold"
        if not names:
            return
        self._vehicle.helm.require("hold")
        for pair in EXCLUSIVE:
            if all(name in names for name in pair):
                raise ValueError(f"{where}: {pair[0]} and {pair[1]}: only one of them can be held")
        if not self._vehicle.released:
            raise ValueError(f"{where}: is docked: release it first")
        for name in names:
            if lack := self._listener.lack(name):
                raise ValueError(f"{where}: {name}: {lack}")
            for kind in (self._listener.kind_for(name), EVERY_HOLD):
                if kind not in MISSES and not self._listener.is_heard(kind):
                    raise ValueError(f"{where}: {name}: its sensor of kind {kind} has no valid reading")

    def take(self, efforts: tuple[float, ...]) -> None:
        """Apply a stick's efforts, which override the holds on the axes where the stick is not at rest."""
        self._aided.stick = efforts
        self._aided.insist()

    def end(self, why: str) -> None:
        """End all holds; whatever ended them now controls the actuators."""
        if not self.targets:
            return
        names = ", ".join(self.targets)
        self.note = f"{names} hold ended: {why}" if why else ""
        self._events.add(self._agenda.tick, self._vehicle.name, "hold_ends", holds=names, why=why)
        self.targets, self._braking, self._pilot = {}, {}, None
        self._aided.last, self._aided.held = ZERO, frozenset()
        self._attend(NEVER)

    def _end_all(self, why: str) -> None:
        """End all holds; the stick alone steers."""
        if self.targets:
            self.end(why)
            self._vehicle.steer_silently(self._aided.stick)

    def act(self, tick: int) -> None:
        """Check the instruments and steer."""
        self.due_tick = tick + self._period_ticks
        failsafe = self._vehicle.failsafe
        if not self._vehicle.released:
            self.end(Reason.DOCKED)
        elif failsafe is not None and failsafe.is_steering:
            self.end(Reason.FAILSAFE)
        else:
            self._listen(tick)
            if self.targets:
                self._steer(tick)

    def save(self) -> dict[str, Any]:
        """Return everything that future steps depend on."""
        return {
            "targets": self.targets,
            "braking": self._braking,
            "silent": self._listener.silent,
            "stick": list(self._aided.stick),
            "efforts": list(self._aided.last),
            "memory": None if self._pilot is None else self._pilot.memory.tolist(),
            "note": self.note,
            "next_control": self.due_tick,
        }

    def restore(self, saved: HoldsState) -> None:
        """Load a state returned by `save`."""
        self.targets = {name: saved.targets[name] for name in HOLDS if name in saved.targets}
        self._braking = {name: saved.braking[name] for name in HOLDS if name in saved.braking}
        self._listener.silent = dict(saved.silent)
        self._aided.stick, self._aided.last = tuple(saved.stick), tuple(saved.efforts)
        self.note = saved.note
        self._pilot = None
        self._aided.held = self._held_axes()
        if saved.memory is not None:
            self._created_pilot().memory = saved.memory
        self._attend(saved.next_control)

    # Instruments

    def _listen(self, tick: int) -> None:
        """End the holds whose instruments have been silent for too long, or replace them with their fallbacks."""
        listener = self._listener
        kinds = {listener.kind_for(name) for name in self.targets} | {EVERY_HOLD}
        listener.listen(kinds | ({COMPASS} if "heading" in self.targets and listener.has(COMPASS) else set()))
        if listener.silence_s(EVERY_HOLD) >= 1.0:
            self._end_all("the IMU is silent")
            return
        for name in list(self.targets):
            kind = listener.kind_for(name)
            if listener.silence_s(kind) >= HOLDS[name].patience_s:
                self._lose(tick, name, kind)
        if listener.silence_s(COMPASS) >= 1.0 and not self.note:
            self.note = "heading held by the gyro alone, and drifts: the compass is silent"

    def _lose(self, tick: int, name: str, kind: str) -> None:
        then = HOLDS[name].then
        can_go_on = then != "" and self._listener.is_heard(self._listener.kind_for(then))
        why = f"the sensor of kind {kind} has no valid reading"
        if not can_go_on and len(self.targets) == 1:
            self._end_all(why)
            return
        del self.targets[name]
        del self._braking[name]
        self.note = f"{name} hold ended: {why}"
        if can_go_on:
            self.note = f"{name} hold became {then} hold: {why}"
            self.targets[then], self._braking[then] = None, tick
        self._events.add(tick, self._vehicle.name, "hold_ends", holds=name, why=why)

    # Steering

    def _held_axes(self) -> frozenset[int]:
        names = {axis for name in self.targets for axis in HOLDS[name].axes} | ({*LEVEL} if self.targets else set())
        return frozenset(AXES.index(axis) for axis in names)

    def _is_manual(self, name: str) -> bool:
        return any(self._aided.stick[AXES.index(axis)] for axis in HOLDS[name].axes)

    def _steer(self, tick: int) -> None:
        """Set the targets of holds on axes where the stick is at rest, and the efforts for one control period."""
        pose, velocity = self._aided.pose, self._aided.velocity
        turn = pose.world_from_body[:3, :3]
        yaw_rad, position_m = float(pose.yaw_rad), pose.position_world_m.tolist()
        moving_m_s = turn @ velocity.linear_body_m_s
        turning_rad_s = float(velocity.angular_body_rad_s[2])
        ahead = (math.cos(yaw_rad), math.sin(yaw_rad))
        along_m_s = float(moving_m_s[0] * ahead[0] + moving_m_s[1] * ahead[1])
        altitude_m = self._listener.value("altitude") if "altitude" in self.targets else math.nan
        now = {
            "heading": ([yaw_rad], abs(turning_rad_s)),
            "depth": ([position_m[2]], abs(moving_m_s[2])),
            "altitude": ([altitude_m], abs(moving_m_s[2])),
            "position": (position_m[:2], math.hypot(*moving_m_s[:2])),
            "speed": ([along_m_s], 0.0),
        }
        for name in self.targets:
            measured, rate = now[name]
            if self._is_manual(name):
                self.targets[name], self._braking[name] = None, tick
            elif self.targets[name] is None and all(map(math.isfinite, measured)):
                has_waited = tick - self._braking[name] >= round(BRAKING_S / PERIOD_S) * self._period_ticks
                if rate < AT_REST[name] or has_waited:
                    self.targets[name] = [float(value) for value in measured]

        free = [math.nan] * 3
        wanted_m_s = moving_m_s.copy()  # for axes that are not held
        if "position" in self.targets:
            free[:2] = self.targets["position"] or free[:2]
            wanted_m_s[:2] = 0.0
        elif "speed" in self.targets:
            (speed_m_s,) = self.targets["speed"] or [along_m_s]
            wanted_m_s[:2] = speed_m_s * ahead[0], speed_m_s * ahead[1]
        if "depth" in self.targets or "altitude" in self.targets:
            free[2], wanted_m_s[2] = self._height_m(position_m[2], altitude_m), 0.0
        (heading_rad,) = self.targets.get("heading") or [yaw_rad]

        pilot = self._created_pilot()
        self._aided.held = self._held_axes()
        before = pilot.memory
        pilot.hold(free, heading_rad, velocity_world_m_s=wanted_m_s)
        self._follow(pilot, before, moving_m_s, turning_rad_s)

    def _height_m(self, z_m: float, altitude_m: float) -> float:
        """Return the z at which the depth or altitude matches its target; NaN while the vehicle comes to rest."""
        if (depth := self.targets.get("depth")) is not None:
            return depth[0]
        if (wanted := self.targets.get("altitude")) is not None and math.isfinite(altitude_m):
            return z_m + wanted[0] - altitude_m
        return math.nan

    def _follow(self, pilot: Controller, before: Any, moving_m_s: Any, turning_rad_s: float) -> None:
        """On axes that no hold steers, freeze the controller's integrals and set its references to the current motion.

        The integrals would wind up, since the controller's efforts do not act there; references equal to the motion let
        the vehicle come to rest at a limited deceleration once the stick is let go.
        """
        memory = np.array(pilot.memory)
        steered = {axis for name in self.targets if not self._is_manual(name) for axis in HOLDS[name].axes}
        if "surge" not in steered:
            memory[0:2], memory[VELOCITY : VELOCITY + 2] = before[0:2], moving_m_s[:2]
        if "heave" not in steered:
            memory[HEAVE_INTEGRAL], memory[VELOCITY + 2] = before[HEAVE_INTEGRAL], moving_m_s[2]
        if "yaw" not in steered:
            memory[YAW_INTEGRAL], memory[TURN + 2] = before[YAW_INTEGRAL], turning_rad_s
        pilot.memory = memory

    def _created_pilot(self) -> Controller:
        if self._pilot is None:
            self._pilot = Controller(self._aided, PERIOD_S, settings=self._vehicle.control)
        return self._pilot
