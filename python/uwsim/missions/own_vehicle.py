"""OwnVehicle: the Vehicle passed to a mission, built from a simulated or remote vehicle, a clock and an estimate."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping
from functools import cached_property, partial
from types import MappingProxyType
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arguments import plain
from uwsim.base.axes import AXES
from uwsim.base.commands import Commandable, command_named
from uwsim.base.named import Named
from uwsim.base.sealed import Sealed
from uwsim.missions.estimated_views import EstimatedCamera, EstimatedImagingSonar, EstimatedSonar
from uwsim.missions.vehicle import CameraLike, HydrophonesLike, ImagingSonarLike, LampLike, Panel, TetherLike, Vehicle
from uwsim.navigation.control.autopilot import Autopilot
from uwsim.navigation.control.controller import Controller
from uwsim.navigation.control.protocols import EstimateLike, PoseLike, SensorLike, SonarLike, VelocityLike, Watch

CONTROL_PERIOD_S = 0.1
SAME_TIME_S = 1e-6
TILT_RAD, TILT_S = math.radians(30.0), 10.0
"""Tilt, and its duration, beyond which a mission warns: the moves assume a vehicle that is nearly level."""
Held = tuple[NDArray[np.float64], float]
"""A position (3,) in the world frame and a heading in radians."""


class TiltWarning(UserWarning):
    """A vehicle has been tilted for long while a mission steered it."""


class Event(NamedTuple):
    """An entry in a mission's log."""

    time_s: float
    vehicle: str
    name: str
    values: dict[str, Any]


class OwnVehicle(Sealed, Commandable):
    """A mission's vehicle; see Vehicle.

    hull: a vehicle from a Simulator, a LiveSimulator or a rosbridge connection. clock: provides time_s. estimate:
    defaults to the hull itself, that is, the truth. hear: called with each logged event.
    """

    name: str
    estimate: EstimateLike
    _fixed_when = "the mission begins"
    _changed_by = MappingProxyType({"effort": "set_effort()", "released": "release(), undock() or dock()"})

    def __init__(
        self,
        hull: Any,
        clock: Watch,
        *,
        estimate: EstimateLike | None = None,
        hear: Callable[[Event], object] = lambda event: None,
    ) -> None:
        self._hull, self._clock, self._hear = hull, clock, hear
        self._efforts: Mapping[str, float] = {}
        self.name = str(getattr(hull, "name", "vehicle"))
        self.estimate = hull if estimate is None else estimate
        self._held: tuple[float, Held] | None = None
        self._tilted_from_s: float | None = None
        self._has_warned = False
        self._methods: dict[str, Callable[..., Any]] = {}

    def __repr__(self) -> str:
        x, y, z = (float(value) for value in self.pose.position_world_m)
        return f"<OwnVehicle '{self.name}' at ({x:.2f}, {y:.2f}, {z:.2f}) m, {self.time_s:.2f} s>"

    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""
        return self._clock.time_s

    @property
    def pose(self) -> PoseLike:
        """The estimated pose."""
        return self.estimate.pose

    @property
    def velocity(self) -> VelocityLike:
        """The estimated velocity."""
        return self.estimate.velocity

    @property
    def tether(self) -> TetherLike | None:
        """The simulated vehicle's tether; None without one, and for a remote vehicle."""
        found: TetherLike | None = getattr(self._hull, "tether", None)
        return found

    @cached_property
    def _autopilot(self) -> Autopilot | Controller:
        settings = getattr(self._hull, "control", None)
        if settings is None:
            return Autopilot(self, CONTROL_PERIOD_S)
        return Controller(self, CONTROL_PERIOD_S, settings=settings)

    @property
    def autopilot(self) -> Autopilot | Controller:
        """The autopilot shared by goto, hold and the other moves, so that its trim and current estimates persist.

        A Controller with the model and gains from the vehicle file, or an Autopilot for a remote vehicle, which
        provides neither. Both have `steer` and `period_s`.
        """
        return self._autopilot

    def held(self) -> Held | None:
        """Return the place that `hold` has been holding, or None if the vehicle has done anything else since."""
        return self._held[1] if self._held is not None and abs(self.time_s - self._held[0]) < SAME_TIME_S else None

    def note_held(self, held: Held) -> None:
        """Record that `hold` has held this place up to the current time."""
        self._held = (self.time_s, held)

    def watch_tilt(self, upright: float) -> None:
        """Warn once, also in the log, of a tilt that lasts. upright: the cosine of the tilt, in each control period."""
        if self._has_warned or upright >= math.cos(TILT_RAD):
            self._tilted_from_s = None
            return
        if self._tilted_from_s is None:
            self._tilted_from_s = self.time_s
        elif self.time_s - self._tilted_from_s >= TILT_S:
            self._has_warned = True
            tilt_deg = math.degrees(math.acos(max(upright, -1.0)))
            self.log("tilted", tilt_deg=round(tilt_deg, 1), duration_s=TILT_S)
            warnings.warn(
                f"vehicle '{self.name}': has been tilted by more than {math.degrees(TILT_RAD):.0f} deg for "
                f"{TILT_S:g} s, now by {tilt_deg:.0f} deg; `uwsim vehicle` reports what tilts it",
                TiltWarning,
                stacklevel=2,
            )

    def beyond_terrain(self, x_m: float, y_m: float, z_m: float = math.inf) -> str | None:
        """Return as text the terrain's bounds, or its height there, if a position is outside or below it; else None.

        None as well if the terrain is unknown, as it is to a remote vehicle.
        """
        find = getattr(self._hull, "beyond_terrain", None)
        return None if find is None else find(x_m, y_m, z_m)

    @property
    def authority(self) -> Any:
        """The effect of full effort on each axis, (6,); None if unknown. See uwsim.simulator.vehicle.Vehicle."""
        return getattr(self._hull, "authority", None)

    @property
    def control(self) -> Any:
        """The model and gains from the vehicle file, for a Controller; None if unknown."""
        return getattr(self._hull, "control", None)

    @property
    def sensors(self) -> Mapping[str, SensorLike]:
        """The sensors, keyed by name."""
        return self._hull.sensors  # type: ignore[no-any-return]

    @property
    def sonar(self) -> SonarLike:
        """The first sonar; its pings are placed at the estimated pose. Raises ValueError if there is none."""
        return self._seen_by_estimate(EstimatedSonar, self._hull.sonar)  # type: ignore[no-any-return]

    @property
    def sonars(self) -> Mapping[str, SonarLike]:
        """The multibeam sonars, keyed by name."""
        return self._all_by_estimate(EstimatedSonar, self._hull.sonars)  # type: ignore[no-any-return]

    @property
    def imaging_sonars(self) -> Mapping[str, ImagingSonarLike]:
        """The imaging sonars, keyed by name; their pings are placed at the estimated pose."""
        return self._all_by_estimate(EstimatedImagingSonar, self._hull.imaging_sonars)  # type: ignore[no-any-return]

    @property
    def hydrophones(self) -> Mapping[str, HydrophonesLike]:
        """The arrays of hydrophones, keyed by name; a remote vehicle's are read from their topics instead."""
        return getattr(self._hull, "hydrophones", {})

    @property
    def cameras(self) -> Mapping[str, CameraLike]:
        """The cameras, keyed by name."""
        return self._all_by_estimate(EstimatedCamera, self._hull.cameras)  # type: ignore[no-any-return]

    @property
    def lamps(self) -> Mapping[str, LampLike]:
        """The lamps, keyed by switch name."""
        return self._hull.lamps  # type: ignore[no-any-return]

    def _seen_by_estimate(self, view: Callable[[Any, Any, Any], Any], part: Any) -> Any:
        return part if self.estimate is self._hull else view(part, self._hull, self.estimate)

    def _all_by_estimate(self, view: Callable[[Any, Any, Any], Any], parts: Any) -> Any:
        if self.estimate is self._hull:
            return parts
        return Named({name: view(part, self._hull, self.estimate) for name, part in parts.items()}, self.name)

    @property
    def released(self) -> bool:
        """Whether the vehicle has left the station."""
        return bool(self._hull.released)

    @property
    def all_stopped(self) -> bool:
        """Whether all stop is set; False for a vehicle that does not report it."""
        return bool(getattr(self._hull, "all_stopped", False))

    def command(self, name: str, /, **arguments: Any) -> Any:
        """Issue a command that a real vehicle could accept. Raises ValueError for any other command."""
        if (method := self._methods.get(name)) is None:
            method = self._methods[name] = self._method(name)
        result = method(**arguments)
        if name == "set_effort":
            self.__dict__["_efforts"] = arguments  # faster than __setattr__, which checks names
        return result

    def _method(self, name: str) -> Callable[..., Any]:
        """Return the hull's method for a command. Raises ValueError if missions may not issue that command."""
        if not (command_named(name).crosses_link or command_named(name).is_ashore):
            raise ValueError(f"vehicle '{self.name}': {name}: not available to missions: real vehicles do not have it")
        found = getattr(self._hull, name) if hasattr(Commandable, name) else partial(self._hull.command, name)
        return cast("Callable[..., Any]", found)

    @property
    def controllable(self) -> frozenset[str]:
        """The axes on which efforts have an effect; all of them for a vehicle that does not report them."""
        return frozenset(getattr(self._hull, "controllable", AXES))

    @property
    def thrusters(self) -> Mapping[str, Any]:
        """The state of each thruster, keyed by name; empty for a vehicle that does not report them."""
        return getattr(self._hull, "thrusters", None) or Named({}, f"{self.name}.thrusters")

    @property
    def fins(self) -> Mapping[str, float]:
        """The current deflections of the fins [rad], keyed by name; empty for a vehicle that does not report them."""
        return getattr(self._hull, "fins", None) or Named({}, f"{self.name}.fins")

    @property
    def effort(self) -> tuple[float, ...]:
        """The surge, sway, heave, roll, pitch and yaw efforts last commanded by this mission."""
        return tuple(self._efforts.get(axis, 0.0) for axis in AXES)

    def telemetry(self) -> Panel:
        """Read the vehicle's panel."""
        return self._hull.telemetry()  # type: ignore[no-any-return]

    def log(self, event: str, **values: Any) -> None:
        """Write an event to the mission's log. Raises ValueError for values that are not of JSON types."""
        kept = {key: plain(value, f"log '{event}': {key}") for key, value in values.items()}
        self._hear(Event(self.time_s, self.name, str(event), kept))


def own_vehicle(vehicle: Vehicle) -> OwnVehicle:
    """Return a mission's vehicle as an OwnVehicle. Any other Vehicle gets a new autopilot."""
    return vehicle if isinstance(vehicle, OwnVehicle) else OwnVehicle(vehicle, vehicle, estimate=vehicle.estimate)
