"""Conversion of a map or a point cloud to another format, selected by the target's suffix."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from uwsim.base.options import need
from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.files import write_cloud
from uwsim.mapping.files.formats import CLOUD_FORMATS, GRID_FORMATS, MAP_FORMATS, Origin, cloud_format, placed_clouds
from uwsim.mapping.files.georeference import Georeference, utm_zone
from uwsim.mapping.files.map_files import open_map, open_points
from uwsim.mapping.files.swath import format_of
from uwsim.mapping.survey_soundings import read_soundings
from uwsim.scenario import load
from uwsim.scenario.georeference import georeference


def convert(
    source: Path,
    target: Path,
    *,
    origin_world_m: Origin = None,
    cell_m: float | None = None,
    scenario: str | None = None,
) -> str:
    """Convert `source` to `target`, written atomically; return a description of the content.

    A map: from a map only. A cloud: the centres of a map's occupied voxels, a cloud's points, or the soundings of a
    survey file, traced from its travel times. A depth grid has cells of cell_m (by default the map's voxels); that of a
    survey file is in its UTM zone and has the uncertainty of its soundings. The scenario's place puts clouds and grids
    on Earth. Raises ValueError or OSError without writing anything.
    """
    suffix = target.suffix.lower()
    known = (*MAP_FORMATS, *CLOUD_FORMATS, *GRID_FORMATS)
    if suffix not in known:
        raise ValueError(f"target '{target}': must end in {', '.join(known)}")
    if suffix not in GRID_FORMATS:
        need(f"a target that ends in {' or '.join(GRID_FORMATS)}", cell=cell_m)
    placed = [*placed_clouds(), *GRID_FORMATS]
    if suffix not in placed:
        need(f"a target that ends in {', '.join(placed)}", scenario=scenario)
    if suffix in MAP_FORMATS:
        if source.suffix not in MAP_FORMATS and cloud_format(source) is not None:
            raise ValueError(f"source '{source}': a cloud has no free space, so it cannot become a map")
        if _is_survey(source):
            raise ValueError(
                f"source '{source}': a survey file becomes a map by `uwsim map build {target} --from {source}`"
            )
        open_map(source, origin_world_m).write(target)
        return "a map"
    place = None if scenario is None else georeference(load(scenario))
    deviations = None
    if _is_survey(source):
        found = read_soundings(source, "source", place)
        points, resolution_m, deviations, place = found.points_m, None, found.deviation_m, found.place
        if scenario is None and suffix in GRID_FORMATS and len(points):
            points, place = _in_utm(points, place)
    else:
        points, resolution_m = open_points(source, origin_world_m)
    if not len(points):
        raise ValueError(
            f"source '{source}': has no {'points' if resolution_m is None else 'occupied voxels'} to write"
        )
    if suffix in CLOUD_FORMATS:
        write_cloud(target, points, place)
        return f"{len(points):,} points"
    width_m = resolution_m if cell_m is None else cell_m
    if width_m is None:
        raise ValueError("cell: missing: points have no voxels that determine the width of the grid's cells")
    grid = depth_grid(points, width_m, deviations)
    GRID_FORMATS[suffix].write(target, grid, Georeference() if place is None else place)
    return f"{grid.depth_m.shape[1]} x {grid.depth_m.shape[0]} cells of {width_m:g} m"


def _is_survey(source: Path) -> bool:
    return source.suffix not in MAP_FORMATS and cloud_format(source) is None and format_of(source) is not None


def _in_utm(points_m: NDArray[np.float64], place: Georeference) -> tuple[NDArray[np.float64], Georeference]:
    """Return points as easting, northing and height in the UTM zone of a place's origin."""
    from rasterio.crs import CRS
    from rasterio.warp import transform

    crs = CRS.from_epsg(utm_zone(*place.degrees(np.zeros(2))))
    east, north = transform(place.crs, crs, *(place.origin[k] + points_m[:, k] for k in (0, 1)))
    return np.column_stack([east, north, points_m[:, 2]]), Georeference(crs)
