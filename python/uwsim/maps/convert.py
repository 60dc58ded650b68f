"""A map or a cloud in another format, chosen by the target's suffix."""

from __future__ import annotations

from pathlib import Path

from uwsim.cloud_files import FORMATS, write_cloud
from uwsim.maps.files import MAP_SUFFIXES, ZERO, Origin, open_map, open_points
from uwsim.maps.geotiff import Georeference, write_depth_tiff
from uwsim.scenario import load
from uwsim.survey.seabed import seabed_grid

TIFF_SUFFIXES = (".tif", ".tiff")


def convert(
    source: Path,
    target: Path,
    *,
    origin_world_m: Origin = ZERO,
    cell_m: float | None = None,
    scenario: str | None = None,
) -> str:
    """Write `source` as `target`, atomically; returns what was written, in words.

    .bt, .ot: of a map only. .ply, .pcd, .las, .xyz: the centres of a map's occupied voxels, or a cloud's points. .tif:
    a depth grid of cells of cell_m (by default the map's voxels), placed on Earth by the scenario's terrain.
    Raises ValueError or OSError, having written nothing.
    """
    suffix = target.suffix.lower()
    known = (*MAP_SUFFIXES, *FORMATS, *TIFF_SUFFIXES)
    if suffix not in known:
        raise ValueError(f"target '{target}': must end in {', '.join(known)}")
    if suffix in MAP_SUFFIXES:
        if source.suffix.lower() in FORMATS:
            raise ValueError(f"source '{source}': a cloud does not say what is free: a map cannot be made of it")
        open_map(source, origin_world_m).write(target)
        return "a map"
    points, resolution_m = open_points(source, origin_world_m)
    if not len(points):
        raise ValueError(
            f"source '{source}': has no {'points' if resolution_m is None else 'occupied voxels'} to write"
        )
    if suffix in FORMATS:
        write_cloud(target, points)
        return f"{len(points):,} points"
    width_m = resolution_m if cell_m is None else cell_m
    if width_m is None:
        raise ValueError("cell: a cloud has no voxels: say how wide the grid's cells are")
    where = Georeference.of(load(scenario) if scenario is not None else None)
    grid = seabed_grid(points, width_m)
    write_depth_tiff(target, grid, where)
    return f"{grid.depth_m.shape[1]} x {grid.depth_m.shape[0]} cells of {width_m:g} m"
