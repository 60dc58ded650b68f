"""The corridors of QGroundControl: lanes beside a polyline, where a plan has only the corridor's own values."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.mapping.files.georeference import Home
from uwsim.missions.field.mission import ITEMS_MAX, FieldFileError, LatLon, lat_lon, number, whole

LEAST_SPACING_M = 0.5
"""Below it, QGroundControl flies the line alone (CorridorScanComplexItem, `_calcTransectSpacing`)."""
TURN_MAX_DEG = 160.0


def corridor_points(entry: Mapping[str, Any], spacing: Any, turnaround: Any) -> list[LatLon]:
    """Return the points of a corridor's lanes in their order of flight. Raises FieldFileError.

    The lanes, of which there are ceil(width / spacing), lie symmetrically about the polyline, the first one to port of
    it, and every other one is flown backwards. The entry point 1 or 3 begins at the last lane, 2 or 3 at the end of the
    line. turnaround: how far [m] lanes go on beyond the line.
    """
    line = entry.get("polyline")
    if not isinstance(line, list) or not 2 <= len(line) <= ITEMS_MAX:
        raise FieldFileError(f"polyline = {line!r:.40}: must have 2 to {ITEMS_MAX} points")
    points = [lat_lon(point, f"polyline, point {k}") for k, point in enumerate(line, 1)]
    width_m = number(entry.get("CorridorWidth"), "CorridorWidth", 0, 1e5, "m")
    spacing_m = number(spacing or 0.0, "CameraCalc.AdjustedFootprintSide", 0, 1e6, "m")
    beyond_m = number(turnaround or 0.0, "TurnAroundDistance", 0, 1e4, "m")
    start = whole(entry.get("EntryPoint", 0), "EntryPoint", 0, 3)
    count = max(math.ceil(width_m / spacing_m), 1) if spacing_m >= LEAST_SPACING_M else 1
    if count * len(points) > ITEMS_MAX:
        raise FieldFileError(
            f"CorridorWidth = {width_m:g} m with lanes {spacing_m:g} m apart: more than {ITEMS_MAX} points"
        )
    place = Home(*points[0])
    line_m = np.array([place.world_m(*point, 0.0)[:2] for point in points])
    line_m = line_m[np.append(True, np.linalg.norm(np.diff(line_m, axis=0), axis=1) > 1e-3)]
    if len(line_m) < 2:
        raise FieldFileError("polyline: has no length")
    offsets_m = [width_m / 2.0 - spacing_m * (k + 0.5) for k in range(count)] if count > 1 else [0.0]
    lanes = [_beside(line_m, offset_m, beyond_m) for offset_m in offsets_m]
    lanes = lanes[::-1] if start in (1, 3) else lanes
    flown = [lane[::-1] if (k % 2 == 1) != (start in (2, 3)) else lane for k, lane in enumerate(lanes)]
    return [place.degrees(np.array([x, y, 0.0])) for lane in flown for x, y in lane.tolist()]


def _beside(line_m: NDArray[np.float64], offset_m: float, beyond_m: float) -> NDArray[np.float64]:
    """Return a line (n, 2) to port of another one at a distance, mitred at its corners, and extended at its ends."""
    along = np.diff(line_m, axis=0)
    along /= np.linalg.norm(along, axis=1)[:, None]
    before, after = np.vstack([along[:1], along]), np.vstack([along, along[-1:]])
    cosines = np.einsum("ij,ij->i", before, after)
    if (sharp := int(np.argmin(cosines))) and cosines[sharp] < math.cos(math.radians(TURN_MAX_DEG)):
        turn_deg = math.degrees(math.acos(max(cosines[sharp], -1.0)))
        raise FieldFileError(
            f"polyline: turns by {turn_deg:.0f} deg at point {sharp + 1}: must be at most {TURN_MAX_DEG:g}"
        )
    to_port = (before + after) / (1.0 + cosines)[:, None] @ np.array([[0.0, 1.0], [-1.0, 0.0]])
    found: NDArray[np.float64] = line_m + offset_m * to_port
    found[0] -= beyond_m * along[0]
    found[-1] += beyond_m * along[-1]
    return found
