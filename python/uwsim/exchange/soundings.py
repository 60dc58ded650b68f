"""Soundings as x y z, gridded or scattered, from text or LAS, as a chart: a GeoTIFF of heights."""

from __future__ import annotations

import re
import warnings
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from affine import Affine
from numpy.typing import NDArray
from rasterio.crs import CRS
from rasterio.errors import CRSError
from rasterio.io import MemoryFile

from uwsim.base.atomic_file import write_atomically
from uwsim.base.caught_warnings import warn_if_cut_short
from uwsim.base.own_files import require_own
from uwsim.base.reader import head_of
from uwsim.base.texts.text_file import decoded, read_limited
from uwsim.mapping.files.georeference import WGS84
from uwsim.scenario.read.note import Note

Floats = NDArray[np.float64]
BYTES_MAX, LINES_SHOWN = 200_000_000, 40
CELLS_MAX = 16_000_000
PER_CELL = 3.0
"""Scattered soundings in a cell, in the mean, by default."""
REACH = 4.0
"""Cells over which a gap between soundings is filled; a wider one stays a gap."""
LINE = 1e-9
"""Ratio of the variances across and along soundings below which they lie in a line."""
ASIDE = 1e-5, 2.3e-5
"""Cells by which a place is moved where its triangle is sought: on an edge, the search would try all."""
EAST = frozenset({"x", "e", "east", "easting", "lon", "lng", "long", "longitude"})
NORTH = frozenset({"y", "n", "north", "northing", "lat", "latitude"})
DEPTHS = frozenset({"d", "depth", "tiefe", "prof", "profondeur", "profundidad"})
HEIGHTS = frozenset({"z", "h", "elev", "elevation", "height", "hoehe"})
DEGREES = frozenset({"lon", "lng", "long", "longitude"})
"""First or last words of the names of columns x, y and z, such as Easting_m or UTM_E, and of those in degrees."""
WORD = re.compile(r"[^\W\d_]+")
NUMBER = re.compile(r"[-+]?(\d+(\.\d*)?|\.\d+)([eE][-+]?\d{1,2})?")


@dataclass
class Soundings:
    """points: (n, 3), x, y and z as in the file. positive: `down` if it names its z a depth. crs: if it states one."""

    path: Path
    points: Floats
    positive: str | None = None
    crs: str | None = None
    notes: list[Note] = field(default_factory=list)


def read_soundings(path: Path) -> Soundings:
    """Return the soundings of a text or LAS file. Raises ValueError, which names a line that is not one, or OSError.

    A text has columns that are separated by spaces, tabs, commas or semicolons; with those, decimal commas are read. A
    first line, or a comment before the first row, may name its columns; without names they are x, y, z, after one that
    counts the rows. Lines that begin with # are comments.
    """
    if head_of(path).startswith(b"LASF"):
        from uwsim.mapping.files.cloud_files import read_cloud

        return Soundings(path, np.asarray(read_cloud(path), np.float64))
    content = read_limited(path, f"'{path}'", BYTES_MAX)
    warn_if_cut_short(f"'{path}'", content)
    lines = decoded(content, f"'{path}'", "text").splitlines()
    first = next((k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")), None)
    if first is None:
        raise ValueError(f"'{path}': is empty: must have lines of x, y, z")
    head = _cells(lines[first])
    is_named, above = not _is_number(head[0], _separator(lines[first])), lines[first - 1].lstrip("# ") if first else ""
    head = head if is_named else _cells(above) if _columns(_cells(above)) else []
    first += is_named
    row = next((line for line in lines[first:] if line.strip() and not line.lstrip().startswith("#")), "")
    separator, columns, found = _separator(row), _columns(head), Soundings(path, np.empty((0, 3)))
    if is_named and columns is None:
        rule = "must name x, y and z, such as by easting, northing, depth or longitude, latitude, elevation"
        raise ValueError(f"'{path}': its first line is '{' '.join(head)[:LINES_SHOWN]}': {rule}")
    width = len(_cells(row))
    is_counted = width == len(head) + 1 if columns else width > 3 and _counts_rows(lines[first:], separator)
    x, y, z = (k + is_counted for k in columns or (0, 1, 2))
    if is_counted:
        found.notes.append(Note("assumed", "the first column, which has no name, counts the rows"))
    if columns:
        named = [head[k] for k in columns]
        found.positive = "down" if _words(named[2]) & DEPTHS else None
        found.crs = WGS84 if _words(named[0]) & DEGREES else None
        left = [name for k, name in enumerate(head) if k not in columns]
        left_out = f"; left out: columns {', '.join(left)}" if left else ""
        found.notes.append(Note("read", f"{', '.join(named)}{left_out}"))
    found.points = _numbers(path, lines, first, separator, (x, y, z))
    return found


def _separator(line: str) -> str | None:
    return next((each for each in (";", "\t", ",") if each in line), None)


def _cells(line: str) -> list[str]:
    return [word.strip().strip("\"'") for word in line.split(_separator(line))]


def _words(name: str) -> set[str]:
    """Return the first and the last word of a column's name without its unit, in small letters."""
    words = WORD.findall(re.split(r"[(\[]", name.lower())[0])
    return {*words[:1], *words[-1:]}


def _columns(head: list[str]) -> tuple[int, int, int] | None:
    """Return the columns x, y and z by their names, None if one is not named."""
    x, y, z = (
        next((k for k, name in enumerate(head) if _words(name) & wanted), None)
        for wanted in (EAST, NORTH, DEPTHS | HEIGHTS)
    )
    return None if x is None or y is None or z is None else (x, y, z)


def _counts_rows(lines: list[str], separator: str | None) -> bool:
    """Return whether the first column is 0, 1, 2, ... or 1, 2, 3, ... in all rows."""
    rows = [line.split(separator, 1)[0].strip() for line in lines if line.strip() and not line.lstrip().startswith("#")]
    return rows in ([str(k) for k in range(begin, begin + len(rows))] for begin in (0, 1))


def _is_number(word: str, separator: str | None) -> bool:
    return NUMBER.fullmatch(word.replace(",", ".") if separator == ";" else word) is not None


def _numbers(path: Path, lines: list[str], first: int, separator: str | None, columns: tuple[int, ...]) -> Floats:
    rows = [line.replace(",", ".") if separator == ";" else line for line in lines[first:]]
    with suppress(ValueError), warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # numpy warns of a text without rows
        points = np.loadtxt(rows, np.float64, delimiter=separator, usecols=columns, ndmin=2)
        if np.isfinite(points).all():
            return points.reshape(-1, 3)
    for number, line in enumerate(rows, first + 1):
        words = [word.strip() for word in line.split("#")[0].split(separator)]
        if any(words) and not all(NUMBER.fullmatch(words[k]) if k < len(words) else None for k in columns):
            raise ValueError(f"'{path}': line {number}: '{lines[number - 1][:LINES_SHOWN]}': must have numbers x, y, z")
    raise ValueError(f"'{path}': must have lines of x, y, z")


def grid_soundings(found: Soundings, out: Path, *, cell: float | None, crs: str | None) -> str:
    """Write soundings as a GeoTIFF, and return how they were gridded.

    Soundings on a regular grid keep their values. Of others, a cell has the median of those in it; an empty one is
    interpolated linearly between its neighbours (Delaunay), unless it is farther than REACH cells from all of them.
    cell: its width, in the unit of x; by default that of a grid, else such that a cell has PER_CELL soundings in the
    mean. Raises ValueError or OSError.
    """
    spreads = np.linalg.eigvalsh(np.cov(found.points[:, :2].T)) if len(found.points) >= 9 else np.zeros(2)
    if spreads[0] <= LINE * spreads[1]:
        raise ValueError(f"'{found.path}': has {len(found.points)} soundings: must have 9 or more, not in a line")
    place = _crs(found, crs)
    x, y = found.points[:, 0], found.points[:, 1]
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
    named, plane = stated or found.crs, found.points[:, :2]
    first, second = np.abs(plane).max(axis=0)
    could_be_degrees = np.ptp(plane, axis=0).max() < 1.0 and min(first, second) <= 90.0 and max(first, second) <= 180.0
    if named is None and could_be_degrees:
        named = WGS84
        order = "longitude and latitude" if second <= 90.0 else "latitude and longitude, since the latter exceeds 90"
        if second > 90.0:
            found.points[:, :2] = plane[:, ::-1]
        found.notes.append(Note("assumed", f"x and y are {order}, {WGS84}: --crs states another, such as local"))
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
        east, north = (np.floor(each / edge).astype(np.int64) for each in (x * squeeze, y))
        if len(x) >= PER_CELL * len(np.unique((east << 32) + north)):
            break
        edge *= 1.2
    return float(edge)


def scattered(path: Path, points: Floats, dx: float, dy: float) -> Floats:
    """Return heights, rows from the north, in cells about whole steps from the least x and the greatest y, else NaN."""
    from scipy.ndimage import binary_erosion, distance_transform_edt
    from scipy.spatial import QhullError

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
        rim = ~empty & ~binary_erosion(~empty, np.ones((3, 3)))  # no triangle of a gap has other corners
        try:
            heights[near] = _between(np.argwhere(rim), heights[rim], np.argwhere(near))
        except QhullError:
            raise ValueError(f"'{path}': has {len(points)} soundings in a line: must cover an area") from None
    return heights


def _between(known: NDArray[np.int64], values: Floats, wanted: NDArray[np.int64]) -> Floats:
    """Return values (m,) at places (m, 2), linear in the triangles (Delaunay) of known ones (n, 2); NaN outside."""
    from scipy.spatial import Delaunay

    mesh = Delaunay(known)
    inside = mesh.find_simplex(wanted + ASIDE)
    beyond = inside < 0
    inside[beyond] = mesh.find_simplex(wanted[beyond])
    corners = mesh.simplices[inside]
    a, b, c = (known[corners[:, k]] for k in range(3))
    (bx, by), (cx, cy), (x, y) = (b - a).T, (c - a).T, (wanted - a).T
    of_b, of_c = (x * cy - y * cx) / (bx * cy - by * cx), (bx * y - by * x) / (bx * cy - by * cx)
    found = (1.0 - of_b - of_c) * values[corners[:, 0]] + of_b * values[corners[:, 1]] + of_c * values[corners[:, 2]]
    return np.where(inside < 0, np.nan, found)


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
