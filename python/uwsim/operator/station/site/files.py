"""Files for pilots to download: the map and the score sheet."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.channels.families.map import PingMap
from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.files import write_cloud
from uwsim.mapping.files.geotiff import write_depth_tiff
from uwsim.operator.station.sessions.running import Running
from uwsim.scenario.georeference import georeference


def map_file(running: Running, vehicle: str) -> bytes:
    """Return a vehicle's map as .bt. Raises ValueError."""
    return _map(running, vehicle).to_bytes()


def cloud(running: Running, vehicle: str, suffix: str) -> bytes:
    """Return the centres of the occupied voxels as .ply or .pcd. Raises ValueError."""
    points_m, _ = _map(running, vehicle).points()
    return _written(f"map.{suffix}", lambda path: write_cloud(path, points_m))


def depth_tiff(running: Running, vehicle: str) -> bytes:
    """Return the depths as GeoTIFF, which is georeferenced if the terrain is. Raises ValueError."""
    points_m, edge_m = _map(running, vehicle).points()
    grid = depth_grid(points_m - running.table.sources[0].origin_m, edge_m)
    place = georeference(running.live.simulator.scenario)
    return _written("map.tif", lambda path: write_depth_tiff(path, grid, place))


def _map(running: Running, vehicle: str) -> PingMap:
    if vehicle not in running.maps:
        raise ValueError(f"vehicle '{vehicle[:40]}': has no map")
    return running.maps[vehicle]


def _written(name: str, write: Callable[[Path], None]) -> bytes:
    with TemporaryDirectory() as folder:
        path = Path(folder, name)
        write(path)
        return path.read_bytes()


def sheet_file(running: Running, name: str) -> bytes:
    """Return a file of the exercise's score sheet. Raises ValueError or OSError if there is none."""
    if running.judged is None:
        raise ValueError("no exercise is flown")
    return running.judged.sheet(name)
