"""A dive's twin: the world from a chart about an area, and the vehicle's model beside the dive's log, with a report."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.mapping.files.georeference import WGS84, metres_per_degree
from uwsim.missions.field.read import read_mission_file
from uwsim.recording.real_flights.beside import fly_beside
from uwsim.recording.real_flights.flight_log import FlightLog
from uwsim.recording.real_flights.motion import at_times, motion_of
from uwsim.recording.real_flights.read import read_flight
from uwsim.scenario import load, load_vehicle
from uwsim.scenario.dump import yaml_text
from uwsim.scenario.from_chart import scenario_from_chart
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.yaml_file import read_yaml
from uwsim.scenario.terrains.elevations import chart_raster
from uwsim.scenario.terrains.raster import RasterTerrain
from uwsim.simulator.simulator import Simulator

SCENARIO, REPORT, SOUNDINGS = "site.yaml", "report.md", "bed.csv"
LEAST_EDGE_M, MOST_EDGE_M = 5.0, 20_000.0
LEAST_SOUNDINGS, LEAST_UPRIGHT = 10, 0.8


@dataclass(frozen=True)
class Twin:
    """The files that were written. notes: lines that begin with known, missing, assumed or unknown."""

    paths: tuple[Path, Path]
    notes: tuple[str, ...]
    table: tuple[tuple[str, ...], ...]


def make_twin(
    area: Path,
    chart: Path,
    log: Path,
    vehicle: str,
    out: Path,
    *,
    columns: str | None = None,
    outputs: str | None = None,
    density_kg_m3: float = 1025.0,
    water_level_m: float = 0.0,
    threads: int | None = None,
) -> Twin:
    """Write the scenario and the report into a folder. Raises OSError, or ValueError with the file and the rule."""
    ring, model = read_ring(area), load_vehicle(vehicle)
    flight = read_flight(log, columns)
    out.mkdir(parents=True, exist_ok=True)
    path, notes = _world(area, ring, chart, vehicle, out / SCENARIO, water_level_m)
    low_m, high_m = _chart_depths(path)
    notes += _dive(flight, low_m, high_m)
    table: list[tuple[str, ...]] = []
    try:
        motion, more = motion_of(flight, model, outputs)
        flown = fly_beside(motion, model, density_kg_m3=density_kg_m3, threads=threads)
        notes += [*more, *flown.notes]
        table = flown.rows()
    except ValueError as error:
        notes.append(f"unknown: how well the model flies: {error}")
    notes.append("unknown: the current, of which neither chart nor log states anything; the scenario has none")
    bed, more = _bed(flight, path)
    notes += more
    if bed is not None:
        write_atomically(out / SOUNDINGS, _csv(bed))
    write_atomically(out / REPORT, _page(area, chart, log, vehicle, notes, table).encode())
    return Twin((path, out / REPORT), tuple(notes), tuple(table))


def read_ring(path: Path) -> NDArray[np.float64]:
    """Return longitude and latitude (n, 2) [deg] around the first area of a file of the field. Raises ValueError."""
    areas = read_mission_file(path).areas
    if not areas:
        raise ValueError(f"{path}: has no area: must have a polygon")
    return np.array(areas[0].corners, np.float64)[:, ::-1]


def _world(
    area: Path, ring: NDArray[np.float64], chart: Path, vehicle: str, path: Path, water_level_m: float
) -> tuple[Path, list[str]]:
    """Write the scenario of the square about an area; return its path and notes."""
    from rasterio.warp import transform

    crs = chart_raster(
        RasterTerrain.model_validate({"source": "raster", "file": chart.resolve(), "water_level_m": water_level_m})
    ).crs
    if crs is None:
        raise ValueError(f"{chart}: states no coordinate system, so that the area cannot be placed in it")
    middle = 0.5 * (ring.min(axis=0) + ring.max(axis=0))
    north_m, east_m = metres_per_degree(float(middle[1]))
    edge_m = float((np.ptp(ring, axis=0) * [east_m, north_m]).max())
    if not LEAST_EDGE_M <= edge_m <= MOST_EDGE_M:
        raise ValueError(f"{area}: is {edge_m:g} m wide: must be {LEAST_EDGE_M:g} to {MOST_EDGE_M:g} m")
    (x,), (y,) = transform(WGS84, crs, [middle[0]], [middle[1]])
    made = scenario_from_chart(chart, path, size_m=edge_m, centre=(x, y), water_level_m=water_level_m)
    place, half_m = georeference(load(path)), 0.5 * made.size_m
    corners = np.array([place.world_m(float(lat), float(lon), 0.0)[:2] for lon, lat in ring])
    inside = np.clip(corners, -half_m, half_m)
    values = dict(read_yaml(path, str(path)).values)
    values["survey"] = {**values["survey"], "area_m": np.round(inside, 2).tolist()}
    model = str(Path(vehicle).resolve()) if Path(vehicle).is_file() else vehicle
    values["vehicles"] = [{**values["vehicles"][0], "model": model}]
    write_atomically(path, yaml_text(values).encode())
    load(path)  # what cannot be flown is refused here
    high, low = made.depth_m
    notes = [f"known: the bed from {chart.name}, {made.size_m:g} m square, {high:.1f} to {low:.1f} m deep"]
    cut_m = float(np.abs(corners - inside).max())
    if cut_m > 1.0:
        notes.append(f"missing: the area beyond the square, by up to {cut_m:.0f} m: the chart has gaps there")
    notes.append(f"assumed: the water's surface is at {water_level_m:g} m of the chart; the tide is unknown")
    return path, notes


def _chart_depths(path: Path) -> tuple[float, float]:
    """Return the shallowest and the deepest depth of a scenario's bed [m]."""
    heights = load(path).terrain.heights()
    return -float(np.nanmax(heights)), -float(np.nanmin(heights))


def _dive(flight: FlightLog, low_m: float, high_m: float) -> list[str]:
    """Return notes about a log, and whether its depth agrees with the chart."""
    notes = flight.notes()
    if "depth" in flight.series:
        deepest_m = float(np.nanmax(flight.series["depth"].values))
        notes.append(f"known: the vehicle dived to {deepest_m:.1f} m, over a bed {low_m:.1f} to {high_m:.1f} m deep")
        if deepest_m > high_m:
            notes.append(f"unknown: why the vehicle was {deepest_m - high_m:.1f} m below the chart's deepest place")
    return notes


def _bed(flight: FlightLog, path: Path) -> tuple[dict[str, NDArray[np.float64]] | None, list[str]]:
    """Return the depths of the bed that the log has along its track beside the chart's, and notes.

    A range is taken along the vehicle's own vertical, up to a tilt of 37 degrees, and as a depth on the track. The
    tide is not known.
    """
    series = flight.series
    lacking = [name for name in ("place", "altitude", "depth") if name not in series]
    if lacking:
        return None, [f"unknown: the bed that the vehicle saw: the log has no {' and no '.join(lacking)}"]
    times_s = series["altitude"].times_s
    lat, lon = at_times(series["place"], times_s, 2).T
    range_m, depth_m = series["altitude"].values[:, 0], at_times(series["depth"], times_s, 1)[:, 0]
    if "attitude" in series:
        x, y, z, w = at_times(series["attitude"], times_s, 4).T
        upright = 1.0 - 2.0 * (x * x + y * y) / (x * x + y * y + z * z + w * w)  # cosine of the tilt
        range_m = np.where(upright > LEAST_UPRIGHT, range_m * upright, np.nan)
    kept = np.isfinite([lat, lon, range_m, depth_m]).all(axis=0)
    scenario = load(path)
    place = georeference(scenario)
    points = np.array([place.world_m(float(a), float(b), 0.0)[:2] for a, b in zip(lat[kept], lon[kept], strict=True)])
    points = points.reshape(-1, 2)
    world = Simulator(scenario).world
    x0, y0, x1, y1 = world.terrain_extent_m
    inside = ((points > (x0, y0)) & (points < (x1, y1))).all(axis=1)
    if inside.sum() < LEAST_SOUNDINGS:
        where = f"{int(inside.sum())} of {int(kept.sum())} ranges with place and depth are over the chart's square"
        return None, [f"unknown: the bed that the vehicle saw: {where}: at least {LEAST_SOUNDINGS} are needed"]
    measured = (depth_m + range_m)[kept][inside]
    charted = -world.height_at(points[inside])
    low, middle, high = np.percentile(measured - charted, [2.5, 50.0, 97.5])
    note = f"known: the bed along the track, from {len(measured)} ranges ({SOUNDINGS}): deeper than the chart by "
    table = {"time_s": times_s[kept][inside], "x_m": points[inside, 0], "y_m": points[inside, 1]}
    return table | {"measured_m": measured, "charted_m": charted}, [
        f"{note}{middle:.2f} m (median; 95 % of them {low:.2f} to {high:.2f} m)"
    ]


def _csv(table: dict[str, NDArray[np.float64]]) -> bytes:
    rows = (",".join(f"{value:.3f}" for value in row) for row in zip(*table.values(), strict=True))
    return "\n".join([",".join(table), *rows, ""]).encode()


def _page(area: Path, chart: Path, log: Path, vehicle: str, notes: list[str], table: list[tuple[str, ...]]) -> str:
    parts = [f"# {log.name} and its twin", "", f"Area {area.name}, chart {chart.name}, vehicle {vehicle}.", ""]
    heads = {"known": "Measured", "assumed": "Assumed", "missing": "Missing", "unknown": "Unknown"}
    for kind, head in heads.items():
        lines = [line.partition(": ")[2] for line in notes if line.startswith(f"{kind}: ")]
        parts += [f"## {head}", "", *(f"- {line}" for line in lines or ["Nothing."]), ""]
    if table:
        rows = [f"| {' | '.join(row)} |" for row in table]
        parts += [
            "## The model beside the log",
            "",
            "Means with 95 % intervals.",
            "",
            rows[0],
            "|" + "---|" * len(table[0]),
            *rows[1:],
            "",
        ]
    return "\n".join(parts)
