"""fly_remote: fly a mission with vehicles at a rosbridge server, either `uwsim serve` or any other."""

from __future__ import annotations

import math
import time
from collections.abc import Iterable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.axes import AXES
from uwsim.base.folder_lock import alone_in
from uwsim.bridges.remote import LockstepClock, RemoteClock, RemoteConnection, RemoteVehicle, vehicle_names
from uwsim.flight.clock import FlightAutosave, FlightOverError, run_to_end
from uwsim.flight.coverage import scored_area_m
from uwsim.flight.folder import remove_stale_results, results_folder
from uwsim.flight.log import MissionLog
from uwsim.flight.mission_file import FUNCTION, load_mission, mission_name, with_arguments
from uwsim.flight.pinging import survey_area_m
from uwsim.flight.record import DONE, INTERRUPTED, FlightRecord
from uwsim.flight.results import MAP, RESULT_FILES, require_report, write_results
from uwsim.flight.samples import COLUMNS, PERIOD_S, Samples
from uwsim.flight.terminal import Silent
from uwsim.mapping import OccupancyMap
from uwsim.mapping.ping_to_map import received_echoes
from uwsim.missions.own_vehicle import Event, OwnVehicle
from uwsim.missions.run import MissionFunction, begin, first_parameter
from uwsim.missions.steps import drive
from uwsim.navigation.control.protocols import Clock
from uwsim.scenario.build.multibeam import VOXEL_M
from uwsim.simulator.simulator import Simulator


def fly_remote(
    mission: MissionFunction | str | Path,
    url: str,
    out: str | Path | None = None,
    *,
    function: str = FUNCTION,
    arguments: Mapping[str, Any] | None = None,
    vehicles: Iterable[str] = (),
    odometry: str = "odom",
    lockstep: bool = False,
    map: bool = False,  # noqa: A002  # named like the command-line option
    voxel_m: float | None = None,
    time_limit_s: float | None = None,
    truth: str | Path | None = None,
    report: str = "full",
    screen: Silent | None = None,
) -> FlightRecord:
    """Fly a mission with vehicles at a rosbridge server; return its record. The results are as for `fly`.

    url: such as "ws://127.0.0.1:9090". vehicles: by default all if the mission takes `vehicles`, else the first.
    odometry: topic of the poses used for map and samples, since the true poses are unknown here. truth: the server's
    scenario, if the server is a uwsim simulator and its odometry is the truth: the map is then scored against it, and
    the report draws its bed. lockstep: whether the simulator waits while the mission computes; works only with a
    simulator. map: whether to build a map. Raises ValueError if an argument is invalid, OSError if the connection fails
    or `out` cannot be written, and the mission's errors.
    """
    file = Path(mission) if isinstance(mission, str | Path) else None
    fly_it = load_mission(file, function) if file is not None else mission
    assert callable(fly_it)
    fly_it = with_arguments(fly_it, arguments or {})
    takes = first_parameter(fly_it)
    require_report(report)
    if voxel_m is not None and not map:
        raise ValueError(f"voxel_m = {voxel_m} m: has no effect unless map=True")
    if time_limit_s is not None and not 0.0 < time_limit_s < math.inf:
        raise ValueError(f"time_limit_s = {time_limit_s} s: must be positive")
    if truth is not None and out is None:
        raise ValueError(f"truth = '{truth}': has no effect without out, the folder for report and score")
    world, screen = None if truth is None else Simulator(truth), screen or Silent()
    with ExitStack() as locked:
        with ExitStack() as stack:
            connection = stack.enter_context(RemoteConnection(url))
            names: tuple[str | None, ...] = tuple(vehicles) or (None,)
            if takes == "vehicles" and not tuple(vehicles):
                names = tuple(vehicle_names(connection)) or names
            hulls = [RemoteVehicle(connection, name, odometry) for name in names]
            inner: RemoteClock | LockstepClock
            if lockstep:
                inner = LockstepClock(connection, hulls[0].beacon)
                stack.callback(inner.close)
            else:
                inner = RemoteClock(connection)
            folder = None if out is None else results_folder(Path(out), (hull.name for hull in hulls))
            if folder is not None:
                locked.enter_context(alone_in(folder))
            log = MissionLog(folder)
            stack.callback(log.close)
            occupancy = OccupancyMap(resolution_m=voxel_m or VOXEL_M) if map else None
            own = {hull.name: OwnVehicle(hull, inner, hear=log.add) for hull in hulls}
            saving = FlightAutosave(0.0, handles_signals=screen.handles_signals)
            flight = _RemoteFlight(inner, log, occupancy, time_limit_s, saving)
            with screen.status(f"flying {mission_name(fly_it, file)} at {url}"), saving.flying():
                flown = flight.fly(fly_it, own, file, url)
        if folder is not None:
            if world is not None:
                flown = replace(flown, area_world_m=scored_area_m(survey_area_m(world), flown.path_world_m))
                sonars = [sonar for hull in world.vehicles.values() for sonar in hull.sonars.values()]
                flown = replace(flown, range_max_m=max((float(s.model.range_limit_m) for s in sonars), default=0.0))
            remove_stale_results(folder, (MAP, *RESULT_FILES), screen)
            flown = write_results(flown, world, folder, "none" if saving.in_haste else report, screen)
    if flown.error is not None:
        raise flown.error
    return flown


class _RemoteFlight:
    """A flight over rosbridge. Also the mission's Clock: it takes samples and pings between waits."""

    def __init__(
        self,
        inner: Clock,
        log: MissionLog,
        occupancy: OccupancyMap | None,
        time_limit_s: float | None,
        autosave: FlightAutosave,
    ) -> None:
        self._inner, self._log, self._occupancy, self._autosave = inner, log, occupancy, autosave
        self._begun_s = inner.time_s
        self._end_s = math.inf if time_limit_s is None else self._begun_s + time_limit_s
        self._limit = f"the time limit of {time_limit_s:g} s is over" if time_limit_s is not None else ""
        self._own: dict[str, OwnVehicle] = {}
        self._rows: dict[str, list[list[float]]] = {}
        self._paths: dict[str, list[NDArray[np.float64]]] = {}
        self._last_pings: dict[str, Any] = {}
        self._echoes, self._sampled_s = 0, -math.inf

    @property
    def time_s(self) -> float:
        """Simulated time in seconds."""
        return self._inner.time_s

    def wait(self, duration_s: float) -> None:
        """Let time pass, in intervals short enough that no ping is missed.

        Raises FlightOverError at the end, OSError if the connection is lost.
        """
        left_s = min(duration_s, max(self._end_s - self.time_s, 1e-6))
        while left_s > 1e-9:
            part_s = min(left_s, 0.5 * PERIOD_S)
            self._inner.wait(part_s)
            left_s -= part_s
            self._look()
            if self._autosave.stop_requested():
                raise FlightOverError(INTERRUPTED)
        if self.time_s >= self._end_s - 1e-6:
            raise FlightOverError(self._limit)

    def fly(self, mission: MissionFunction, own: dict[str, OwnVehicle], file: Path | None, url: str) -> FlightRecord:
        """Fly until the flight ends, for whatever reason; return its record."""
        self._own = own
        self._rows, self._paths = {name: [] for name in own}, {name: [] for name in own}
        began_s, name = time.perf_counter(), mission_name(mission, file)
        self._log_event("begun", {"mission": name, "url": url})
        self._look()
        end = run_to_end(lambda: drive(begin(mission, own), self), file, foreign=(OSError,))
        if not isinstance(end.error, OSError):  # the connection is lost
            for vehicle in own.values():
                vehicle.set_effort()
        self._log_event("ended", {"because": end.because})
        return FlightRecord(
            mission=name,
            scenario=url,
            seed=None,
            estimate="odometry",
            step_s=None,
            ended_because=end.because,
            ended_early=end.because not in (DONE, self._limit),
            simulated_s=self._rows[next(iter(own))][-1][0] - self._begun_s,
            wall_s=time.perf_counter() - began_s,
            events=self._log.events,
            samples={name: Samples(_NAMES, np.array(rows)) for name, rows in self._rows.items()},
            result=end.result,
            error=end.error,
            occupancy=self._occupancy,
            voxel_m=0.0 if self._occupancy is None else self._occupancy.resolution_m,
            pings_world_m={name: np.array(path).reshape(-1, 3) for name, path in self._paths.items()},
            echo_count=self._echoes,
        )

    def _look(self) -> None:
        """Take samples if due, and insert new pings."""
        now_s = self.time_s
        if now_s >= self._sampled_s + PERIOD_S - 1e-6:
            self._sampled_s = now_s
            for name, vehicle in self._own.items():
                self._rows[name].append(_row(now_s, vehicle))
        if self._occupancy is not None:
            for name, vehicle in self._own.items():
                self._insert(name, vehicle.sonar.ping(), self._occupancy)

    def _insert(self, name: str, ping: Any, occupancy: OccupancyMap) -> None:
        if ping is self._last_pings.get(name):
            return
        self._last_pings[name] = ping
        pose = ping.world_from_sonar
        points = received_echoes(ping.points_sonar_m[ping.valid].astype(np.float64), pose)
        occupancy.insert_scan(points, pose[:3, 3], max_range_m=1e4)
        self._paths[name].append(pose[:3, 3].copy())
        self._echoes += len(points)

    def _log_event(self, event: str, values: dict[str, Any]) -> None:
        self._log.add(Event(self.time_s, "", event, values))


_NAMES = (*COLUMNS, *(f"effort {axis}" for axis in AXES))


def _row(time_s: float, vehicle: OwnVehicle) -> list[float]:
    pose, panel = vehicle.pose, vehicle.telemetry()
    rotation, position = pose.world_from_body, np.asarray(pose.position_world_m).tolist()
    return [
        time_s,
        *position,
        math.atan2(rotation[2, 1], rotation[2, 2]),
        -math.asin(min(max(float(rotation[2, 0]), -1.0), 1.0)),
        float(pose.yaw_rad),
        *position,
        float(pose.yaw_rad),
        -position[2],
        panel.distance_to_seabed_m,
        float(np.linalg.norm(vehicle.velocity.linear_body_m_s)),
        panel.battery_percent,
        panel.distance_to_station_m,
        vehicle.released,
        *(float(getattr(panel, f"{name}_warning", False)) for name in ("range", "proximity", "collision")),
        0.0,
        *np.asarray(vehicle.velocity.linear_body_m_s).tolist(),
        *np.asarray(vehicle.velocity.angular_body_rad_s).tolist(),
        *vehicle.effort,
    ]
