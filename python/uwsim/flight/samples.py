"""Samples vehicles in flight at a fixed rate in simulated time, and derives events from the samples."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arguments import plain
from uwsim.base.atomic_file import write_atomically
from uwsim.base.axes import AXES
from uwsim.base.wall_timer import Measurement
from uwsim.flight.log import PANEL_WARNINGS, lit
from uwsim.instruments.gauges import GAUGES
from uwsim.mapping.files.georeference import Georeference
from uwsim.missions.own_vehicle import OwnVehicle
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from pandas import DataFrame

PERIOD_S = 0.2
COLUMNS = (
    "time_s", "x_m", "y_m", "z_m", "roll_rad", "pitch_rad", "yaw_rad",
    "estimated_x_m", "estimated_y_m", "estimated_z_m", "estimated_yaw_rad",
    "depth_m", "altitude_m", "speed_m_s", "battery_percent", "distance_to_station_m",
    "released", "range_warning", "proximity_warning", "collision_warning", "collisions",
    "surge_m_s", "sway_m_s", "heave_m_s", "roll_rate_rad_s", "pitch_rate_rad_s", "yaw_rate_rad_s",
)  # fmt: skip
EARTH_COLUMNS = ("latitude_deg", "longitude_deg")
COMMANDS = ("thruster ", "effort ")
"""Prefixes of the names of columns with commands."""
TOO_MANY = {"set_wrench", "set_thrusters", "set_fins", "link_send"}
"""Commands that, like set_effort, are too frequent to log."""
AT = {name: k for k, name in enumerate(COLUMNS)}
_ATTRIBUTES = {gauge.column: gauge.attribute for gauge in GAUGES}
_FIGURES = attrgetter(*(_ATTRIBUTES.get(name, name) for name in COLUMNS[AT["depth_m"] : AT["released"]]))
LIT_AT = slice(AT["range_warning"], AT["collision_warning"] + 1)
OnEvent = Callable[[str, str, dict[str, Any]], object]
"""A function called with a vehicle's name, an event's name and its values."""


@dataclass(frozen=True, eq=False)
class Samples:
    """The samples of one vehicle; a column such as `samples["depth_m"]` has shape (n,).

    The motion is the true motion, with rates in body axes (REP 103). Further columns are "fin NAME", the deflections
    [rad]; `Sensor.numbers`; and "thruster NAME" or, for a vehicle without thrusters, "effort AXIS", the commands in
    [-1, 1]. Sensor columns contain the newest readings as a mission would read them, and NaN if the sensor is off.
    """

    names: tuple[str, ...]
    values: NDArray[np.float64]

    def __getitem__(self, name: str) -> NDArray[np.float64]:
        return self.values[:, self.names.index(name)]

    def __len__(self) -> int:
        return len(self.values)

    def pandas(self) -> DataFrame:
        """Return the samples as a pandas DataFrame, indexed by time_s. Raises ImportError without pandas."""
        import pandas  # an optional dependency

        return pandas.DataFrame(self.values, columns=list(self.names)).set_index("time_s")

    def __repr__(self) -> str:
        return f"<Samples: {len(self)} of {', '.join(self.names[:4])} ... {len(self.names)} columns>"

    def plot(self) -> Figure:
        """Return a figure of the true path seen from above, coloured by height."""
        from uwsim.scoring.track_plot import plot  # imported here, since matplotlib takes a second

        return plot(self.path_world_m, title=repr(self))

    def _repr_png_(self) -> bytes:
        from uwsim.scoring.track_plot import png

        return png(self.plot())

    @property
    def path_world_m(self) -> NDArray[np.float64]:
        """True positions in the world, (n, 3)."""
        return self.values[:, AT["x_m"] : AT["z_m"] + 1]

    @property
    def estimated_path_world_m(self) -> NDArray[np.float64]:
        """Estimated positions in the world, (n, 3)."""
        return self.values[:, AT["estimated_x_m"] : AT["estimated_z_m"] + 1]

    @property
    def commands(self) -> NDArray[np.float64]:
        """Commands in [-1, 1], (n, thrusters or axes)."""
        return self.values[:, len(self.names) - len(self.command_names) :]

    @property
    def command_names(self) -> tuple[str, ...]:
        """Names of the thrusters or axes, in the order of `commands`."""
        return tuple(name.partition(" ")[2] for name in self.names if name.startswith(COMMANDS))

    def lit_s(self, warning: str) -> float:
        """Return the time for which a panel warning was on [s], to the resolution of the samples."""
        return float(self[f"{warning}_warning"].sum()) * PERIOD_S

    def write(self, path: Path, place: Georeference | None = None) -> None:
        """Write a CSV file; with a place on Earth, also latitude and longitude (WGS 84). Raises OSError."""
        names, row, values = self.names, ",".join(["%.6g"] * len(self.names)), self.values
        if place is not None and place.crs is not None:
            names, row = (*names, *EARTH_COLUMNS), row + ",%.9f" * len(EARTH_COLUMNS)
            values = np.hstack([values, place.degrees(self.path_world_m)])
        header = ",".join(name.replace(" ", "_") for name in names)
        lines = [header, *(row % tuple(each) for each in values.tolist())]
        write_atomically(path, ("\n".join(lines) + "\n").encode())


class Sampler:
    """Samples a simulator's vehicles and reports changes on their panels as events, as an Observer of its journal.

    vehicles: the vehicles by name, as seen by the mission. on_event: receives events. timer: measures the time spent on
    sampling. with_sensors: whether the samples include the sensors' readings, which take longer than everything else.
    """

    def __init__(
        self, sim: Simulator, vehicles: Mapping[str, OwnVehicle], on_event: OnEvent, timer: Measurement, *,
        with_sensors: bool = True,
    ) -> None:  # fmt: skip
        self._sim, self._on_event, self._timer = sim, on_event, timer
        self._steps = max(1, round(PERIOD_S / sim.step_s))
        self._vehicles = [(name, sim.vehicles[name], own) for name, own in vehicles.items()]
        self._columns = {name: _Columns(sim.vehicles[name], with_sensors) for name in vehicles}
        self._rows: dict[str, list[list[float]]] = {name: [] for name in vehicles}
        self.observe()

    def observe(self) -> None:
        """Take a sample of each vehicle."""
        self.due_tick = self._sim.tick + self._steps
        with self._timer:
            for name, vehicle, own in self._vehicles:
                row, rows = _row(self._sim.time_s, vehicle, own), self._rows[name]
                row += self._columns[name].read()
                self._note_changes(name, rows[-1] if rows else None, row)
                rows.append(row)

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Report a command as an event, unless such commands are too frequent or only observe the vehicle."""
        if name not in TOO_MANY and arguments.get("use", "steering") == "steering":
            values = {k: plain(v, k) for k, v in arguments.items() if k != "vehicle" and not isinstance(v, bytes)}
            self._on_event(str(arguments.get("vehicle") or ""), name, values)

    def samples(self) -> dict[str, Samples]:
        """Return all samples so far, by vehicle."""
        found = {}
        for name, columns in self._columns.items():
            names = (*COLUMNS, *columns.names)
            found[name] = Samples(names, np.array(self._rows[name], np.float64).reshape(-1, len(names)))
        return found

    def _note_changes(self, name: str, before: list[float] | None, row: list[float]) -> None:
        were_lit = [False] * len(PANEL_WARNINGS) if before is None else before[LIT_AT]
        if row[LIT_AT] != were_lit:
            for warning, is_lit, was_lit in zip(PANEL_WARNINGS, row[LIT_AT], were_lit, strict=True):
                if is_lit != was_lit:
                    self._on_event(name, f"{warning}_warning", {"lit": bool(is_lit)})
        if before is None:
            return
        if (more := row[AT["collisions"]] - before[AT["collisions"]]) > 0:
            self._on_event(name, "collision", {"times": int(more)})
        if row[AT["battery_percent"]] <= 0.0 < before[AT["battery_percent"]]:
            self._on_event(name, "battery_empty", {})


class _Columns:
    """The columns of one vehicle after COLUMNS: its fins, sensors and commands."""

    def __init__(self, vehicle: Vehicle, with_sensors: bool) -> None:
        self._vehicle = vehicle
        self._sensors = list(vehicle.sensors.values()) if with_sensors else []
        self._has_thrusters = bool(vehicle.thrusters)
        sensors = [name for sensor in self._sensors for name in sensor.numbers]
        commands = [f"thruster {one}" for one in vehicle.thrusters] or [f"effort {axis}" for axis in AXES]
        self.names = (*(f"fin {fin}" for fin in vehicle.fins), *sensors, *commands)

    def read(self) -> list[float]:
        """Return the current values, in the order of `names`."""
        vehicle = self._vehicle
        found: list[float] = list(vehicle.fins.values())
        for sensor in self._sensors:
            found += sensor.flat(sensor.read())
        if self._has_thrusters:
            return [*found, *(one.command for one in vehicle.thrusters.values())]
        return [*found, *vehicle.effort.tolist()]


def _row(time_s: float, vehicle: Vehicle, own: OwnVehicle) -> list[float]:
    pose, panel = vehicle.pose, vehicle.telemetry()
    position, yaw = pose.position_world_m.tolist(), pose.yaw_rad
    estimated, estimated_yaw = position, yaw
    if own.estimate is not vehicle:
        estimated, estimated_yaw = np.asarray(own.pose.position_world_m).tolist(), float(own.pose.yaw_rad)
    upward_x, upward_y, upward_z, _ = pose.world_from_body[2].tolist()
    return [
        time_s,
        *position,
        math.atan2(upward_y, upward_z),
        -math.asin(min(max(upward_x, -1.0), 1.0)),
        yaw,
        *estimated,
        estimated_yaw,
        *_FIGURES(panel),
        vehicle.released,
        *lit(panel),
        vehicle.collisions,
        *vehicle.velocity.linear_body_m_s.tolist(),
        *vehicle.velocity.angular_body_rad_s.tolist(),
    ]
