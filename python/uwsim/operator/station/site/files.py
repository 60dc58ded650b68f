"""Files for pilots to download: a vehicle's map."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.files import write_cloud
from uwsim.mapping.files.geotiff import write_depth_tiff
from uwsim.operator.station.sessions.running import Running
from uwsim.scenario.georeference import georeference


def map_file(running: Running, vehicle: str, suffix: str) -> tuple[bytes, str]:
    """Return a vehicle's map, and a name for the file, which names its world. Raises ValueError.

    suffix: bt for the map itself, ply or pcd for the centres of its occupied voxels, tif for the depths as GeoTIFF,
    which is georeferenced if the terrain is.
    """
    if vehicle not in running.maps:
        raise ValueError(f"vehicle '{vehicle[:40]}': has no map")
    found, scenario = running.maps[vehicle], running.live.simulator.scenario
    name = f"{scenario.name}-{vehicle}.{suffix}"
    if suffix == "bt":
        return found.to_bytes(), name
    points_m, edge_m = found.points()
    with TemporaryDirectory() as folder:
        path = Path(folder, f"map.{suffix}")
        if suffix == "tif":
            grid = depth_grid(points_m - running.table.sources[0].origin_m, edge_m)
            write_depth_tiff(path, grid, georeference(scenario))
        else:
            write_cloud(path, points_m)
        return path.read_bytes(), name
