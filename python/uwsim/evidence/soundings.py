"""Soundings as x y z, gridded or scattered, from text or LAS, as a chart: a GeoTIFF of heights."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from affine import Affine
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.errors import CRSError
from rasterio.io import MemoryFile

from uwsim.base.atomic_file import write_atomically
from uwsim.base.cut_short import warn_if_cut_short
from uwsim.base.own_files import require_own
from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.mapping.files.georeference import WGS84

Floats = NDArray[np.float64]
BYTES_MAX, LINES_SHOWN = 200_000_000, 40
CELLS_MAX = 16_000_000
PER_CELL = 3.0
"""Scattered soundings in a cell, in the mean, by default."""
REACH = 4.0
"""Cells over which a gap between soundings is filled; a wider one stays a gap."""
NAMES = (
    re.compile(r"^(x|e|east(ing)?|lon(g|gitude)?)\b", re.IGNORECASE),
    re.compile(r"^(y|n|north(ing)?|lat(itude)?)\b", re.IGNORECASE),
    re.compile(r"^(z|d|depth|elev(ation)?|height|h|tiefe|prof)", re.IGNORECASE),
)
"""Names of the columns x, y and z in a first line."""
DOWN = re.compile(r"^(d|depth|tiefe|prof)", re.IGNORECASE)
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d{1,2})?")
DEGREES = re.compile(r"^(lon|lat)", re.IGNORECASE)


@dataclass
class Soundings:
    """points: (n, 3), x, y and z as in the file. positive: `down` if it names its z a depth. crs: if it states one."""

    path: Path
    points: Floats
    positive: str | None = None
    crs: str | None = None
    notes: list[str] = field(default_factory=list)


def read_soundings(path: Path) -> Soundings:
    """Return the soundings of a text or LAS file. Raises ValueError, which names a line that is not one, or OSError.

    A text has columns that are separated by spaces, tabs, commas or semicolons; with those, decimal commas are read. A
    first line may name its columns; without one they are x, y, z. Lines that begin with # are comments.
    """
    if path.suffix.lower() == ".las":
        from uwsim.mapping.files.cloud_files import read_cloud

        return Soundings(path, np.asarray(read_cloud(path), np.float64))
    content = read_limited(path, f"'{path}'", BYTES_MAX)
    warn_if_cut_short(f"'{path}'", content)
    lines = decoded(content, f"'{path}'", "text").splitlines()
    first = next((k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)
    if first is None:
        raise ValueError(f"'{path}': is empty: must have lines of x, y, z")
    separator = next((each for each in (";", "\t", ",") if each in lines[first]), None)
    head = [word.strip().strip("\"'") for word in lines[first].split(separator)]
    found, columns = Soundings(path, np.empty((0, 3))), (0, 1, 2)
    if not _is_number(head[0], separator):
        columns = _columns(path, head)
        first += 1
        named = [head[k] for k in columns]
        found.positive = "down" if DOWN.match(named[2]) else None
        found.crs = WGS84 if DEGREES.match(named[0]) else None
        left = [name for k, name in enumerate(head) if k not in columns]
        found.notes.append(f"read: {', '.join(named)}" + (f"; left out: columns {', '.join(left)}" if left else ""))
    found.points = _numbers(path, lines, first, separator, columns)
    return found


def _columns(path: Path, head: list[str]) -> tuple[int, int, int]:
    places = [next((k for k, name in enumerate(head) if wanted.match(name)), None) for wanted in NAMES]
    if None in places:
        rule = "must name x, y and z, such as by easting, northing, depth or longitude, latitude, elevation"
        raise ValueError(f"'{path}': its first line is '{' '.join(head)[:LINES_SHOWN]}': {rule}")
    x, y, z = (place for place in places if place is not None)
    return x, y, z


def _is_number(word: str, separator: str | None) -> bool:
    return NUMBER.fullmatch(word.replace(",", ".") if separator == ";" else word) is not None


def _numbers(path: Path, lines: list[str], first: int, separator: str | None, columns: tuple[int, ...]) -> Floats:
    last, rows = max(columns), []
    for number, line in enumerate(lines[first:], first + 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        words = [word.strip() for word in (line.replace(",", ".") if separator == ";" else line).split(separator)]
        if len(words) <= last or not all(NUMBER.fullmatch(words[k]) for k in columns):
            raise ValueError(f"'{path}': line {number}: '{line[:LINES_SHOWN]}': must have numbers x, y, z")
        rows.append([float(words[k]) for k in columns])
    return np.array(rows, np.float64).reshape(-1, 3)


def grid_soundings(found: Soundings, out: Path, *, cell: float | None, crs: str | None) -> str:
    """Write soundings as a GeoTIFF, and return how they were gridded.

    Soundings on a regular grid keep their values. Of others, a cell has the median of those in it; an empty one is
    interpolated linearly between its neighbours (Delaunay), unless it is farther than REACH cells from all of them.
    cell: its width, in the unit of x; by default that of a grid, else such that a cell has PER_CELL soundings in the
    mean. Raises ValueError or OSError.
    """
    place = _crs(found, crs)
    x, y = found.points[:, 0], found.points[:, 1]
    if len(x) < 9 or np.ptp(x) == 0.0 or np.ptp(y) == 0.0:
        raise ValueError(f"'{found.path}': has {len(x)} soundings: must have 9 or more, not in a line")
    require_own(out)
    grid = _regular(found.points) if cell is None else None
    if grid is not None:
        heights, (dx, dy), how = *grid, "on a regular grid, whose values are kept"
    else:
        squeeze = float(np.cos(np.radians(np.mean(y)))) if place is not None and place.is_geographic else 1.0
        dx = cell if cell is not None else default_cell(x, y, squeeze) / squeeze
        dy = dx * squeeze
        heights = scattered(found.path, found.points, dx, dy)
        how = f"scattered: the median of each cell of {dx:.4g}, gaps up to {REACH:g} cells interpolated linearly"
    write_atomically(out, geotiff(heights, Affine(dx, 0.0, x.min() - dx / 2, 0.0, -dy, y.max() + dy / 2), place))
    known = np.isfinite(heights).mean()
    return f"{len(x)} soundings, {how}: {out}, {100.0 * known:.0f} % of {heights.size} cells"


def _crs(found: Soundings, stated: str | None) -> CRS | None:
    """Return the coordinate system: that stated, that of the file, or that of degrees where all could be degrees."""
    x, y = found.points[:, 0], found.points[:, 1]
    named = stated or found.crs
    if named is None and np.abs(x).max() <= 180.0 and np.abs(y).max() <= 90.0 and max(np.ptp(x), np.ptp(y)) < 1.0:
        named = WGS84
        found.notes.append(f"assumed: x and y are longitude and latitude, {WGS84}: --crs states another, such as local")
    if named is None or named == "local":
        return None
    try:
        return CRS.from_user_input(named)
    except (CRSError, ValueError):
        raise ValueError(f"--crs {named}: must be a coordinate system, such as EPSG:32632, or local") from None


def _regular(points: Floats) -> tuple[Floats, tuple[float, float]] | None:
    """Return heights (rows from north, columns) and spacings, if the soundings are most nodes of a regular grid."""
    x, y, z = points.T
    axes = []
    for values in (x, y):
        nodes = np.unique(values)
        steps = np.diff(nodes)
        if len(nodes) < 3 or np.ptp(steps) > 0.01 * steps.mean() or len(nodes) > len(values):
            return None
        axes.append((nodes[0], float(steps.mean()), len(nodes)))
    (x0, dx, columns), (y0, dy, rows) = axes
    if len(points) < 0.5 * rows * columns:
        return None
    heights = np.full((rows, columns), np.nan)
    heights[rows - 1 - np.rint((y - y0) / dy).astype(int), np.rint((x - x0) / dx).astype(int)] = z
    return heights, (dx, dy)


def default_cell(x: Floats, y: Floats, squeeze: float) -> float:
    """Return the edge of a cell of which each has PER_CELL soundings, in the mean of those that have any."""
    edge = np.sqrt(max(np.ptp(x) * squeeze, 1e-12) * max(np.ptp(y), 1e-12) / len(x))
    for _ in range(40):
        cells = np.unique(np.column_stack([np.floor(x * squeeze / edge), np.floor(y / edge)]), axis=0)
        if len(x) >= PER_CELL * len(cells):
            break
        edge *= 1.2
    return float(edge)


def scattered(path: Path, points: Floats, dx: float, dy: float) -> Floats:
    """Return heights, rows from the north, in cells about whole steps from the least x and the greatest y, else NaN."""
    from scipy.interpolate import LinearNDInterpolator
    from scipy.ndimage import distance_transform_edt

    x, y, z = points.T
    columns, rows = np.rint((x - x.min()) / dx).astype(np.int64), np.rint((y.max() - y) / dy).astype(np.int64)
    shape = int(rows.max()) + 1, int(columns.max()) + 1
    if shape[0] * shape[1] > CELLS_MAX:
        raise ValueError(f"'{path}': {shape[1]} x {shape[0]} cells of {dx:g}: must be at most {CELLS_MAX}: --cell")
    if min(shape) < 3:
        raise ValueError(f"'{path}': {shape[1]} x {shape[0]} cells of {dx:g}: must be 3 x 3 or more: --cell")
    order = np.lexsort((z, rows * shape[1] + columns))
    cells, starts, counts = np.unique((rows * shape[1] + columns)[order], return_index=True, return_counts=True)
    low, high = z[order][starts + (counts - 1) // 2], z[order][starts + counts // 2]
    heights = np.full(shape, np.nan)
    heights.ravel()[cells] = 0.5 * (low + high)
    empty = np.isnan(heights)
    near = empty & (distance_transform_edt(empty) <= REACH)
    if near.any():
        known = np.argwhere(~empty)
        heights[near] = LinearNDInterpolator(known, heights[~empty])(np.argwhere(near))
    return heights


def geotiff(heights: Floats, place: Affine, crs: CRS | None) -> bytes:
    """Return a GeoTIFF of heights, rows from the north. place: from column and row to x and y, at pixels' corners."""
    rows, columns = heights.shape
    with MemoryFile() as memory:
        with memory.open(
            driver="GTiff", width=columns, height=rows, count=1, dtype="float64", nodata=float("nan"), crs=crs,
            transform=place, compress="deflate",
        ) as file:  # fmt: skip
            file.write(heights, 1)
        return bytes(memory.read())
