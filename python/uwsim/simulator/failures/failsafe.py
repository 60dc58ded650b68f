"""Failsafe: a vehicle's autonomous reaction to silence or to an onboard alarm."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Any, Literal

from pydantic import Field, FiniteFloat, NonNegativeInt

from uwsim.base.agenda import NEVER
from uwsim.base.saved_state import State, Tick
from uwsim.base.sealed import Sealed
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.sensor_choice import altimeter
from uwsim.scenario.spec.battery import Failsafe as Figures
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.simulator.failures import manoeuvres
from uwsim.simulator.failures.alarms import LOOK_S, Alarms, Cause, FailsafeCause
from uwsim.simulator.failures.events import EventLog
from uwsim.simulator.failures.manoeuvres import Beginning
from uwsim.simulator.failures.steered import ZERO, Steered
from uwsim.simulator.vehicle import Vehicle

PERIOD_S = 0.05  # period of the control loop
SILENCE = "silence"


class BeginningState(State):
    """The pose and time at which a manoeuvre began; see uwsim.simulator.failures.manoeuvres."""

    x_m: FiniteFloat
    y_m: FiniteFloat
    z_m: FiniteFloat
    yaw_rad: FiniteFloat
    time_s: FiniteFloat


class FailsafeState(State):
    """A saved failsafe. pilot: state of its Controller, if it is steering. lit, counts, last: state of its Alarms."""

    state: Literal["", "hold", "surface", "return", "go_on"]
    cause: Literal[""] | FailsafeCause
    heard_tick: Tick
    free_tick: Tick
    was_free: bool
    overridden: list[str]
    began: BeginningState
    pilot: Annotated[list[FiniteFloat], Field(min_length=25, max_length=25)] | None
    efforts: Annotated[list[Annotated[float, Field(ge=-1, le=1)]], Field(min_length=6, max_length=6)]
    lit: dict[str, Cause]
    counts: dict[str, NonNegativeInt]
    last: dict[str, list[float]]
    next_look: Tick
    next_control: Tick


class Failsafe(Sealed):
    """The failsafe of one vehicle; see uwsim.scenario.spec.battery for its parameters.

    It acts only while the vehicle is released. state: its reaction: "" (none), hold, surface, return or go_on. cause:
    silence, battery, leak, thruster or sensor. alarms: the active alarms, as text. home_m: the position to which it
    returns.
    """

    figures: Figures
    home_m: tuple[float, float, float]

    def __init__(
        self,
        vehicle: Vehicle,
        figures: Figures,
        model: VehicleModel,
        *,
        home_m: tuple[float, float, float],
        events: EventLog,
        step_s: float,
        tick: Callable[[], int],
        water_kg: Callable[[], float] = lambda: 0.0,
        link_silence_s: Callable[[], float] | None = None,
    ) -> None:
        """home_m: the position to which it returns. water_kg: returns the mass of water inside the hull.

        link_silence_s: returns how long the link has been silent, if there is a link.
        """
        self.figures = figures
        self.home_m = home_m
        self._vehicle = vehicle
        self._model = model
        self._events = events
        self._step_s = step_s
        self._tick = tick
        self._water_kg = water_kg
        self._link_silence_s = link_silence_s
        self._steered = Steered(vehicle)
        self._pilot: Controller | None = None
        self.restart()

    def restart(self) -> None:
        """Return to the state at the start of a run."""
        self._state = self._cause = ""
        self._heard_tick = self._free_tick = 0
        self._was_free = False
        self._overridden: set[str] = set()
        self._began = Beginning(0.0, 0.0, 0.0, 0.0, 0.0)
        self._pilot = None
        self._steered.last = ZERO
        self._alarms = Alarms(self._model, self.figures)
        self._next_look = 0
        self._next_control = NEVER

    @property
    def state(self) -> str:
        """The failsafe's current reaction."""
        return self._state

    @property
    def cause(self) -> str:
        """The cause of the reaction."""
        return self._cause

    @property
    def alarms(self) -> tuple[str, ...]:
        """The active alarms, as text."""
        return tuple(self._alarms.lit)

    @property
    def is_steering(self) -> bool:
        """True while the reaction moves the vehicle."""
        return self._state in ("hold", "surface", "return")

    @property
    def has_control(self) -> bool:
        """True while the failsafe steers, so that commands have no effect.

        Without a link, the failsafe does not have control during a silence, because any command ends the silence.
        """
        is_ended_by_commands = self._cause == SILENCE and self._link_silence_s is None
        return self.is_steering and not is_ended_by_commands

    def note_command(self) -> None:
        """Register a command, which ends a silence; with a link, only a command that arrived over the link does."""
        tick = self._heard_tick = self._tick()
        if self._cause == SILENCE and not self._is_silent(tick):
            self._end()

    def insist(self) -> None:
        """Reapply the last efforts, since a command has just replaced them."""
        self._steered.insist()

    def override(self) -> None:
        """Return control to the pilot; the current cause will not trigger a reaction again in this run."""
        if self._cause and self._cause != SILENCE:
            self._overridden.add(self._cause)
        self._end()

    @property
    def due_tick(self) -> int:
        """The tick of the next check or control period."""
        return min(self._next_look, self._next_control)

    def act(self, tick: int) -> None:
        """Check the vehicle and steer it."""
        if tick >= self._next_look:
            self._look(tick)
        if tick >= self._next_control:
            self._steer(tick)
            self._next_control = tick + self._ticks(PERIOD_S)

    def save(self) -> dict[str, Any]:
        """Return everything that future steps depend on."""
        return {
            "state": self._state,
            "cause": self._cause,
            "heard_tick": self._heard_tick,
            "free_tick": self._free_tick,
            "was_free": self._was_free,
            "overridden": sorted(self._overridden),
            "began": vars(self._began),
            "pilot": None if self._pilot is None else self._pilot.memory.tolist(),
            "efforts": list(self._steered.last),
            "lit": self._alarms.lit,
            "counts": self._alarms.counts,
            "last": self._alarms.last,
            "next_look": self._next_look,
            "next_control": self._next_control,
        }

    def restore(self, saved: FailsafeState) -> None:
        """Load a state returned by `save`."""
        self._state, self._cause = saved.state, saved.cause
        self._heard_tick, self._free_tick, self._was_free = saved.heard_tick, saved.free_tick, saved.was_free
        self._overridden, self._began = set(saved.overridden), Beginning(**dict(saved.began))
        self._alarms = Alarms(self._model, self.figures, saved.lit, saved.counts, saved.last)
        self._next_look, self._next_control = saved.next_look, saved.next_control
        self._steered.last = tuple(saved.efforts)
        self._pilot = None
        if saved.pilot is not None:
            self._created_pilot().memory = saved.pilot

    # Checking and steering

    def _look(self, tick: int) -> None:
        self._next_look = tick + self._ticks(LOOK_S)
        if not self._vehicle.released:
            self._was_free = False
            self._end()
            return
        if not self._was_free:
            self._was_free = True
            self._heard_tick, self._free_tick = max(self._heard_tick, tick), tick
        if self._watches_aboard:
            self._look_aboard(tick)
        if self._cause == SILENCE and not self._is_silent(tick):
            self._end()
        if self.figures.silence_s is None or self._state:
            return
        if self._is_silent(tick):
            self._begin(tick, self.figures.then, SILENCE, silence_s=self.figures.silence_s)
        else:
            left = self._ticks(self.figures.silence_s) - self._silence_ticks(tick)
            self._next_look = min(self._next_look, tick + max(left, 1))

    def _is_silent(self, tick: int) -> bool:
        return self.figures.silence_s is not None and self._silence_ticks(tick) >= self._ticks(self.figures.silence_s)

    def _silence_ticks(self, tick: int) -> int:
        """Return the number of ticks since the last command or, with a link, since the last packet over the link."""
        if self._link_silence_s is None:
            return tick - self._heard_tick
        return min(round(self._link_silence_s() / self._step_s), tick - self._free_tick)

    @property
    def _watches_aboard(self) -> bool:
        figures = self.figures
        watched = (figures.leak_then, figures.thruster_then, figures.sensor_then)
        return figures.battery_percent > 0 or any(then is not None for then in watched)

    def _look_aboard(self, tick: int) -> None:
        before = set(self._alarms.lit)
        lit = self._alarms.look(self._vehicle, self._water_kg())
        for name in lit:
            if name not in before:
                self._events.add(tick, self._vehicle.name, "alarm", what=name)
        for name in sorted(before - set(lit)):
            self._events.add(tick, self._vehicle.name, "alarm_ends", what=name)
        for name, cause in lit.items():
            then = getattr(self.figures, f"{cause}_then")
            if cause not in self._overridden and (not self._state or self._outranks(then)):
                self._begin(tick, then, cause, what=name)

    def _outranks(self, then: str) -> bool:
        """Return whether a reaction takes precedence over the current one."""
        order = ("go_on", "hold", "return", "surface")
        return order.index(then) > order.index(self._state) or (self._cause == SILENCE and then != "go_on")

    def _begin(self, tick: int, then: str, cause: str, **values: Any) -> None:
        self._state, self._cause = then, cause
        self._began = self._beginning(tick)
        self._pilot = None
        self._next_control = NEVER if then == "go_on" else tick
        self._events.add(tick, self._vehicle.name, "failsafe", then=then, cause=cause, **values)

    def _beginning(self, tick: int) -> Beginning:
        pose = self._steered.pose
        x_m, y_m, z_m = pose.position_world_m.tolist()
        return Beginning(x_m, y_m, z_m, float(pose.yaw_rad), tick * self._step_s)

    def _end(self) -> None:
        if not self._state:
            return
        if self.is_steering and self._vehicle.released:
            self._steered.set_effort()
        self._events.add(self._tick(), self._vehicle.name, "failsafe_ends", cause=self._cause)
        self._state = self._cause = ""
        self._next_control = NEVER
        self._pilot = None

    def _steer(self, tick: int) -> None:
        if self._vehicle.all_stopped:  # restarts from the vehicle's position when all stop is released
            self._began, self._pilot = self._beginning(tick), None
            return
        pilot, time_s = self._created_pilot(), tick * self._step_s
        if self._state == "hold":
            manoeuvres.hold(pilot, self._began)
        elif self._state == "surface":
            manoeuvres.surface(pilot, self._began, self.figures, time_s)
        elif self._state == "return":
            manoeuvres.fly_back(pilot, self._began, self.figures, time_s, self.home_m, self._above_bed_m())

    def _above_bed_m(self) -> float:
        sensor = altimeter(self._vehicle.sensors)
        sample = None if sensor is None else sensor.sample()
        return float(sample.value) if sample is not None and sample.valid else math.inf

    def _created_pilot(self) -> Controller:
        if self._pilot is None:
            self._pilot = Controller(self._steered, PERIOD_S, settings=self._vehicle.control)
        return self._pilot

    def _ticks(self, duration_s: float) -> int:
        return max(1, round(duration_s / self._step_s))
