"""The request for a flight, with every default and the survey's area resolved: enough to rebuild simulator and maps."""

from __future__ import annotations

import hashlib
import math
import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import ConfigDict

from uwsim.flight.field_flight import FieldNote
from uwsim.mapping import MapEngine, OccupancyMap
from uwsim.mapping.files.georeference import Home, Place
from uwsim.missions.field import Area, FieldFileError, read_mission_file
from uwsim.missions.items import SPEED_M_S
from uwsim.scenario import AnyScenario, Scenario, ScenarioError, Survey, load
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.validated import validated
from uwsim.simulator.simulator import Simulator


def with_survey(scenario: AnyScenario, changes: Mapping[str, Any]) -> Scenario:
    """Return a scenario with values of its survey replaced. Raises ScenarioError."""
    found = scenario if isinstance(scenario, Scenario) else load(scenario)
    given = {} if found.survey is None else dict(found.survey)
    if found.survey is None and (missing := [way for key, way in NEEDED.items() if key not in changes]):
        raise ScenarioError(f"scenario '{found.name}': has no survey: needs {' and '.join(missing)}")
    return found.model_copy(update={"survey": validated(Survey, {**given, **changes})})


NEEDED = {
    "area_m": "--area",
    "altitude_m": "--altitude, or 'altitude' of the area",
    "line_spacing_m": "--spacing, --overlap or 'spacing' of the area",
}
NAMES = {"spacing_m": "line_spacing_m", "speed": "speed_m_s"}


def survey_changes(
    scenario: AnyScenario, area: Path | None = None, overlap: float | None = None, **lanes: Any
) -> dict[str, Any]:
    """Return the changed values of a scenario's survey, and warn of what a file has that is not flown.

    area: a file of the field with a polygon. overlap: of neighbouring swaths [%], which determines the distance
    between lanes. lanes: heading_deg, altitude_m, spacing_m, speed [m/s], entry and cross_lines, if not None, in place
    of the file's. Raises ValueError or OSError.
    """
    found = scenario if isinstance(scenario, Scenario) else load(scenario)
    changes = {NAMES.get(key, key): value for key, value in lanes.items() if value is not None}
    if overlap is not None and lanes.get("spacing_m") is not None:
        raise ValueError("--overlap and --spacing: must not both be given")
    if found.survey is None and "speed_m_s" not in changes:
        changes["speed_m_s"] = SPEED_M_S
        warnings.warn(f"scenario '{found.name}': has no survey: {SPEED_M_S:g} m/s is assumed", FieldNote, stacklevel=2)
    if area is not None:
        first = _area(area, found, changes)
        if first.spacing_m is not None:
            changes.setdefault("line_spacing_m", first.spacing_m)
        if first.altitude_m is not None:
            changes.setdefault("altitude_m", first.altitude_m)
        if first.heading_deg is not None:
            changes.setdefault("heading_deg", first.heading_deg)
    if overlap is not None:
        changed = with_survey(found, {"line_spacing_m": 1.0} | changes)
        changes["line_spacing_m"] = (1.0 - overlap / 100.0) * swath_m(changed)
    return changes


def _area(file: Path, scenario: Scenario, changes: dict[str, Any]) -> Area:
    """Return the first area of a file, and put its corners in the world into the changes."""
    mission = read_mission_file(file)
    if not mission.areas:
        raise FieldFileError(f"{file}: has no area: must have a polygon or a survey")
    first, *others = mission.areas
    notes = list(mission.notes)
    if others:
        notes.append(f"{len(others)} areas after {first.name}: left out")
    if any(not area.in_items for area in mission.areas) and mission.items:
        notes.append(f"{len(mission.items)} items beside the area: left out")
    place: Place = georeference(scenario)
    if getattr(place, "crs", None) is None:
        middle = np.asarray(first.corners).mean(axis=0)
        at = np.zeros(2) if scenario.survey is None else np.asarray(scenario.survey.area_m).mean(axis=0)
        place = Home(float(middle[0]), float(middle[1]), float(at[0]), float(at[1]))
        notes.append(
            f"scenario '{scenario.name}' is not on Earth: the middle of {first.name} is assumed at "
            f"({at[0]:.1f}, {at[1]:.1f}) m east and north of the origin"
            + (", the middle of its survey" if scenario.survey is not None else "")
        )
    changes["area_m"] = [[float(v) for v in place.world_m(lat, lon, 0.0)[:2]] for lat, lon in first.corners]
    for note in notes:
        warnings.warn(f"{file}: {note}", FieldNote, stacklevel=3)
    return first


def swath_m(scenario: Scenario) -> float:
    """Return the width of the first vehicle's multibeam swath on a flat bed, at the survey's altitude and tilt.

    The fan lies in a plane that is tilted by t below the horizon and meets the bed at altitude / sin t ahead of the
    head. A beam at an angle a from the middle reaches it after altitude / (sin t cos a), which must be within its
    range. Raises ScenarioError.
    """
    survey, setup = scenario.survey, scenario.vehicles[0].sonar
    if survey is None or setup is None:
        lacks = "survey" if survey is None else f"sonar of vehicle '{scenario.vehicles[0].name}'"
        raise ScenarioError(f"scenario '{scenario.name}': has no {lacks}, which an overlap of swaths needs")
    band = setup.loaded.band(setup.frequency_hz)
    sine = math.sin(math.radians(survey.tilt_deg))
    ahead_m = survey.altitude_m / max(sine, 1e-9)
    if ahead_m >= band.range_max_m:
        rule = f"must be less than its range, {band.range_max_m:g} m, for an overlap of swaths"
        raise ScenarioError(f"survey: the sonar meets the bed after {ahead_m:.1f} m at {survey.altitude_m:g} m: {rule}")
    half_rad = min(math.radians(band.field_of_view_deg) / 2.0, math.acos(ahead_m / band.range_max_m))
    return 2.0 * ahead_m * math.tan(half_rad)


EstimateKind = Literal["truth", "filter"]
ESTIMATES: tuple[EstimateKind, ...] = ("truth", "filter")
OF_SIMULATOR = ("seed", "sonar_model", "sonar_frequency_hz", "vehicle_model", "mission_time_s", "link")
"""Names of the arguments of the simulator."""


@dataclass(frozen=True)
class FlightRequest:
    """The arguments that determine a flight.

    mission: the path of its file, or `module:name`; if None, the scenario's survey. mission_digest: digest of the file.
    vehicles: by default the scenario's first, or all if the mission takes `vehicles`. vehicle_model: replaces the first
    vehicle's. link: a modem that replaces the scenario's. survey: values that replace those of the scenario's survey.
    carried: name endings of the channels that vehicles send over the link. time_limit_s: limit in simulated time; by
    default the battery life. voxel_m, engine, verify_map, outlier_filter, map_growth: options of the map, if one is
    built. sample_sensors: whether `samples` include the sensors' readings.
    """

    __pydantic_config__ = ConfigDict(extra="forbid")

    mission: str | None = None
    function: str = "mission"
    mission_digest: str | None = None
    arguments: dict[str, Any] = field(default_factory=dict)
    scenario: str = "lake"
    seed: int | None = None
    sonar_model: int | str | None = None
    sonar_frequency_hz: float | None = None
    vehicle_model: str | None = None
    mission_time_s: float | None = None
    link: str | None = None
    survey: dict[str, Any] = field(default_factory=dict)
    carried: tuple[str, ...] | None = None
    vehicles: tuple[str, ...] = ()
    estimate: EstimateKind = "truth"
    map: bool = False
    voxel_m: float | None = None
    engine: MapEngine = "bricks"
    verify_map: bool = False
    outlier_filter: bool | None = None
    map_growth: bool = True
    sample_sensors: bool = True
    time_limit_s: float | None = None

    def new_simulator(self, threads: int | None = None) -> Simulator:
        """Return a new simulator for the flight. Raises ScenarioError or ValueError if the request is invalid."""
        scenario = with_survey(self.scenario, self.survey) if self.survey else self.scenario
        return Simulator(scenario, threads=threads, **{name: getattr(self, name) for name in OF_SIMULATOR})

    def new_reference(self) -> OccupancyMap | None:
        """Return an empty stock OctoMap for verification if requested, else None."""
        assert self.voxel_m is not None or not self.verify_map
        return OccupancyMap(resolution_m=self.voxel_m or 1.0, engine="octomap") if self.verify_map else None


def resolved_path(name: Any) -> Any:
    """Return the absolute path of a file; return anything else, such as a packaged scenario's name, unchanged."""
    if isinstance(name, str | Path):
        return str(Path(name).resolve()) if Path(name).is_file() else str(name)
    return name


def file_digest(path: Path) -> str:
    """Return a digest of a file's content. Raises OSError."""
    return hashlib.blake2b(path.read_bytes(), digest_size=16).hexdigest()
