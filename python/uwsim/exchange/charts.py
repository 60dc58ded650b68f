"""A scenario from a chart: a real place from a BAG, a GeoTIFF, an S-102 or a NetCDF of elevations, ready to survey."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import remove_own_file, require_own
from uwsim.base.reader import Reader
from uwsim.exchange.scenario_source import Made
from uwsim.scenario.dump import yaml_text
from uwsim.scenario.read.note import Note
from uwsim.scenario.terrains.elevations import chart_raster
from uwsim.scenario.terrains.raster import RasterTerrain
from uwsim.scenario.terrains.raster_file import Raster

SUFFIXES = (".bag", ".tif", ".tiff", ".h5", ".nc", ".grd", ".asc", ".img", ".vrt")
SOUNDED = (".xyz", ".csv", ".txt", ".dat", ".las", ".laz")
SIZE_M = 500.0
MARGIN_CELLS = 1.0
MOST_SPACINGS = 2000
SPACINGS_PER_CELL, LEAST_SPACING_M, MOST_SPACING_M = 4, 0.25, 100.0
NAME_LENGTH = 40
SURVEY_SHARE, SURVEY_MAX_M, ALTITUDE_M = 0.6, 100.0, 12.0
GUESSES = ("it is in plain metres, without a place on Earth", "its cells are degrees of EPSG:4326")
WHOLE = 1e-9  # a share of a spacing by which an edge may fall short by rounding


@dataclass(frozen=True)
class FromChart:
    """A scenario that was made. depth_m: shallowest and deepest of its bed. size_m: its edge.

    notes: what is assumed of the chart, such as a coordinate system that it does not name.
    """

    path: Path
    size_m: float
    depth_m: tuple[float, float]
    notes: tuple[Note, ...] = ()


def scenario_from_chart(
    chart: Path, out: Path, *, size_m: float, centre: tuple[float, float] | None = None, water_level_m: float = 0.0,
    band: int = 1, **stated: Any,
) -> FromChart:  # fmt: skip
    """Write a scenario whose bed is the largest square of a chart without gaps, or the part of it about its middle.

    size_m: the largest edge. centre: of the square, in the chart's coordinates (longitude and latitude, or easting and
    northing). water_level_m: elevation of the water surface in the chart. stated: unit, nodata, positive and crs, where
    the file does not state them; see RasterTerrain. Raises OSError or ValueError.
    """
    if out.suffix not in (".yaml", ".yml"):
        raise ValueError(f"--out {out}: must end in .yaml")
    require_own(out)
    read = {"water_level_m": water_level_m, "band": band}
    read |= {key: value for key, value in stated.items() if value is not None}
    raster = chart_raster(RasterTerrain.model_validate({"source": "raster", "file": chart.resolve(), **read}))
    column, row, side = _square(raster, chart, centre)
    x, y = raster.place_at(column, row)
    cell_m = raster.safe_cell_m((x, y))
    edge_m = min(size_m, (side - MARGIN_CELLS) * cell_m)
    spacing_m = max(LEAST_SPACING_M, min(cell_m / SPACINGS_PER_CELL, MOST_SPACING_M, edge_m), edge_m / MOST_SPACINGS)
    edge_m = math.floor(edge_m / spacing_m + WHOLE) * spacing_m
    half = max(1, math.ceil(0.5 * edge_m / cell_m))
    rows, columns = raster.elevations.shape
    part = raster.elevations[_span(row, half, rows), _span(column, half, columns)]
    part = part[np.isfinite(part)] - water_level_m
    shallow_m, deep_m = -float(part.max()), -float(part.min())
    if shallow_m < 1.0:
        down = ": its heights are all positive: if they are depths, give --positive down" if deep_m < 0.0 else ""
        raise ValueError(f"'{chart}': its largest part without gaps reaches {-shallow_m:g} m above the water surface: "
                         f"must lie 1 m below it or deeper: choose --centre and --size{down}")  # fmt: skip
    values = _values(chart, out, (x, y), edge_m, spacing_m, (shallow_m, deep_m), read)
    write_atomically(out, yaml_text(values).encode())
    guess = f"'{chart.name}' names no coordinate system: {GUESSES[raster.is_geographic]}: --crs states another"
    return FromChart(out, edge_m, (shallow_m, deep_m), () if raster.names_crs else (Note("assumed", guess),))


def _values(
    chart: Path, out: Path, centre: tuple[float, float], edge_m: float, spacing_m: float, depth_m: tuple[float, float],
    read: dict[str, Any],
) -> dict[str, Any]:  # fmt: skip
    half_m = round(0.5 * min(SURVEY_SHARE * edge_m, SURVEY_MAX_M), 2)
    plain = "".join(c if c.isascii() and (c.isalnum() or c in "-_") else "_" for c in out.stem)
    name = (plain if plain[0].isalpha() else f"chart_{plain}")[:NAME_LENGTH]
    altitude_m = round(min(ALTITUDE_M, 0.5 * depth_m[0]), 2)
    return {
        "name": name,
        "description": f"{edge_m:g} m of the sea floor in {chart.name}, {depth_m[0]:.1f} to {depth_m[1]:.1f} m deep",
        "mission_time_s": 7200,
        "water": {"salinity_psu": 35},
        "terrain": {
            "source": "raster", "file": _path_from(out, chart), **read,
            "centre": [float(each) for each in centre], "size_m": [edge_m, edge_m], "spacing_m": spacing_m,
            "interpolation": "linear",
        },
        "vehicles": [{
            "name": "rov", "model": "rov",
            "start": {"position_m": [-half_m, -half_m, round(-max(0.5, depth_m[0] - 2.0 * altitude_m), 2)]},
            "sonar": {"model": 2, "tilt_deg": 90},
        }],
        "survey": {
            "area_m": [[-half_m, -half_m], [half_m, -half_m], [half_m, half_m], [-half_m, half_m]],
            "altitude_m": altitude_m, "line_spacing_m": altitude_m, "speed_m_s": 1.0, "tilt_deg": 90,
        },
    }  # fmt: skip


def _path_from(out: Path, chart: Path) -> str:
    """Return the chart's path as the scenario's file has it: relative to it, if it is in the same folder or below."""
    there, here = chart.resolve(), out.resolve().parent
    return str(there.relative_to(here)) if there.is_relative_to(here) else str(there)


def _square(raster: Raster, chart: Path, centre: tuple[float, float] | None) -> tuple[float, float, int]:
    """Return column and row of the middle (pixel corners) and the edge, in cells, of the largest square without gaps.

    centre: the middle, if it is given. Raises ValueError.
    """
    known = np.isfinite(raster.elevations)
    if centre is None:
        edges = _largest_squares(known)
        row, column = divmod(int(edges.argmax()), edges.shape[1])
        side = int(edges[row, column])
        middle = column + 1 - side / 2, row + 1 - side / 2
    else:
        middle = raster.corner_at(*centre)
        side = 0
        while _is_full(known, middle, side + 1):
            side += 1
    if side < 3:
        where = "is without gaps" if centre is None else f"about --centre {centre[0]:g} {centre[1]:g} is without gaps"
        raise ValueError(f"'{chart}': no square of 3 x 3 cells {where}")
    return *middle, side


def _largest_squares(known: NDArray[np.bool_]) -> NDArray[np.int32]:
    """Return, for each cell, the edge of the largest square of known cells whose last row and column it is in."""
    edges = known.astype(np.int32)
    # Rows depend on earlier rows, and cells of a row on the one before: diagonals are independent.
    rows, columns = known.shape
    for diagonal in range(2, rows + columns - 1):
        row = np.arange(max(1, diagonal - columns + 1), min(rows, diagonal))
        column = diagonal - row
        least = np.minimum(np.minimum(edges[row - 1, column], edges[row, column - 1]), edges[row - 1, column - 1])
        edges[row, column] = np.where(known[row, column], least + 1, 0)
    return edges


def _is_full(known: NDArray[np.bool_], middle: tuple[float, float], side: int) -> bool:
    column, row = (math.floor(each - side / 2) for each in middle)
    if min(row, column) < 0 or row + side + 1 > known.shape[0] or column + side + 1 > known.shape[1]:
        return False
    return bool(known[row : row + side + 1, column : column + side + 1].all())


def _span(middle: float, half: int, count: int) -> slice:
    return slice(max(0, math.floor(middle - half)), min(count, math.ceil(middle + half)))


def _named_after(path: Path) -> Path:
    return Path(path.stem.lower().replace(" ", "_") + ".yaml")


def _from_chart(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    stated = {key: options[key] for key in STATED if key in options}
    made = scenario_from_chart(
        path, out or _named_after(path), size_m=options.get("size", SIZE_M), centre=options.get("centre"),
        water_level_m=options.get("water_level", 0.0), **stated,
    )  # fmt: skip
    size, (high, low) = f"{made.size_m:g} x {made.size_m:g} m", made.depth_m
    made_of = Note("", f"{size}, {high:.1f} to {low:.1f} m deep; uwsim survey {made.path}")
    return Made(made.path, [made_of, *made.notes])


def _from_soundings(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    """Grid soundings into a GeoTIFF beside the scenario, and make it from that."""
    from uwsim.exchange.soundings import grid_soundings, read_soundings

    out = out or _named_after(path)
    found = read_soundings(path)
    read = {key: value for key, value in options.items() if key not in ("cell", "crs")}
    if found.positive is not None:
        read.setdefault("positive", found.positive)
    chart = out.with_suffix(".tif")
    note = grid_soundings(found, chart, cell=options.get("cell"), crs=options.get("crs"))
    try:
        made = _from_chart(chart, out, read)
    except (ValueError, OSError):
        remove_own_file(chart)
        raise
    return Made(made.path, [*found.notes, Note("", note), *made.notes])


STATED = ("unit", "nodata", "positive", "crs")
OPTIONS = ("size", "centre", "water_level", *STATED)
CHART = Reader(
    f"a chart ({', '.join(SUFFIXES)})", lambda path, head: path.is_file() and path.suffix.lower() in SUFFIXES,
    _from_chart, OPTIONS,
)  # fmt: skip
SOUNDINGS = Reader(
    f"soundings as x y z ({', '.join(SOUNDED)})", lambda path, head: path.is_file() and path.suffix.lower() in SOUNDED,
    _from_soundings, (*OPTIONS, "cell"),
)  # fmt: skip
