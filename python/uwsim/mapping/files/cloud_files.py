"""Point cloud files: PCD, PLY, LAS, LAZ and plain XYZ text, written by their suffix and read by their content.

write_cloud("bed.ply", points_m)
points_m = read_cloud("bed.ply")

PCD, PLY and XYZ preserve float32 points bit for bit; XYZ also float64; LAS and LAZ store whole millimetres.
PCD and PLY have doubles where a float32 would move a point by more than a millimetre.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.caught_warnings import warn_if_cut_short
from uwsim.base.texts.text_file import require_regular
from uwsim.mapping.files.formats import CLOUD_FORMATS, CloudFormat, cloud_format, placed_clouds
from uwsim.mapping.files.georeference import Georeference

MAX_HEADER = 65_536


def write_cloud(path: str | os.PathLike[str], points_m: ArrayLike, place: Georeference | None = None) -> None:
    """Write points (n, 3) atomically, in the format given by the file suffix, one of CLOUD_FORMATS.

    place: writes world points in geographic coordinates. Raises
    ValueError, before writing anything, for another suffix or shape, if there are no points or non-finite points, or
    for a place that is not on Earth or that the format does not hold; OSError if the file cannot be written.
    """
    target = Path(path)
    if target.suffix.lower() not in CLOUD_FORMATS:
        raise ValueError(f"cloud path '{target}': must end in {', '.join(CLOUD_FORMATS)}")
    form, points = CLOUD_FORMATS[target.suffix.lower()], _finite_points(points_m)
    if place is None:
        data = form.encode(points)
    elif form.encode_at is None:
        raise ValueError(f"cloud path '{target}': holds no place on Earth; {', '.join(placed_clouds())} do")
    elif place.crs is None:
        raise ValueError(f"cloud path '{target}': the world has no place on Earth: give its scenario the key earth")
    else:
        data = form.encode_at(points, place)
    write_atomically(target, data)


def read_cloud(path: str | os.PathLike[str]) -> Floats:
    """Return the points in a file, (n, 3) float64, except non-finite ones, which PCL writes for missing echoes.

    Warns if the last line of a text file has no line break. Raises OSError if the file cannot be read, ValueError if it
    is not valid in the format that its content is in.
    """
    source = Path(path)
    data, form = _read(source)
    with _named(source, form):
        points: Floats = form.read(data)
    if form.text_mark is not None and form.text_mark in data[:MAX_HEADER]:
        warn_if_cut_short(f"'{source}'", data)
    return points[np.isfinite(points).all(axis=1)]


def seen_from(path: Path) -> Floats | None:
    """Return where the points of a file were seen from, (3,), if it states that. Raises as `read_cloud` does."""
    data, form = _read(path)
    if form.seen_from is None:
        return None
    with _named(path, form):
        return form.seen_from(data)


def _read(path: Path) -> tuple[bytes, CloudFormat]:
    try:
        require_regular(path)
        data = path.read_bytes()
    except OSError as error:
        raise OSError(f"'{path}': cannot be read: {error.strerror or error}") from None
    if (form := cloud_format(path)) is None:
        raise ValueError(f"'{path}': must be a {', a '.join(each.what for each in CLOUD_FORMATS.usable().values())}")
    return data, form


@contextmanager
def _named(path: Path, form: CloudFormat) -> Iterator[None]:
    try:
        yield
    except Exception as error:  # a malformed file can make the libraries raise any exception
        reason = " ".join(str(error).split()) or type(error).__name__
        raise ValueError(f"'{path}': not a valid {form.what}: {reason}") from None


def _finite_points(points_m: ArrayLike) -> NDArray[np.floating]:
    points = np.asarray(points_m)
    if points.dtype.kind not in "fiu" or points.dtype.itemsize > 8:
        raise ValueError(f"points_m.dtype = {points.dtype}: must be real numbers")
    if points.ndim != 2 or points.shape[1] != 3:
        raise ValueError(f"points_m.shape = {points.shape}: expected (n, 3)")
    if not len(points):
        raise ValueError("points_m: no points to write")
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        first = int(np.argmax(bad))
        raise ValueError(f"points_m[{first}] = {points[first]} m: must be finite")
    return points if points.dtype == np.float32 else points.astype(np.float64)


FINEST_M = 1e-3


def rounded(points_m: NDArray[np.floating]) -> NDArray[np.floating]:
    """Return finite points (n, 3), little-endian and C-ordered: float32, as most programs expect.

    float64 if that would move a point by more than a millimetre, as it does 16 km from zero, in georeferenced clouds.
    """
    with np.errstate(over="ignore"):
        single = np.ascontiguousarray(points_m, "<f4")
    return single if np.abs(single - points_m).max() <= FINEST_M else np.ascontiguousarray(points_m, "<f8")
