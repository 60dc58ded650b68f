"""Scans and maps shipped with liboctomap-dev produce the same bytes as with OctoMap's own programs."""

import bz2
import struct
import subprocess
from pathlib import Path

import numpy as np
import pytest

from uwsim.mapping import OccupancyMap

DATA = Path("/usr/share/doc/liboctomap-dev/examples/data")
SCANS_PER_BATCH = 5


def graph2tree(graph, folder, *options):
    """Insert a scan graph with OctoMap's graph2tree; return the bytes of its .ot and .bt files."""
    subprocess.run(
        ["graph2tree", "-i", graph, "-o", folder / "tree.bt", "-g", *options],
        check=True,
        capture_output=True,
        timeout=600,
    )
    return (folder / "tree.bt.ot").read_bytes(), (folder / "tree.bt").read_bytes()


def read_graph(path):
    """Return a graph's point clouds (n, 3) float32, in world coordinates, and origins (3,)."""
    data = path.read_bytes()
    (nodes,) = struct.unpack_from("<I", data)
    at, scans = 4, []

    def vectors(count, numbers):
        # each vector is stored as a count followed by that many float64
        nonlocal at
        rows = np.frombuffer(data, dtype=[("n", "<u4"), ("x", "<f8", numbers)], count=count, offset=at)
        at += rows.nbytes
        return rows["x"]

    for _ in range(nodes):
        (points,) = struct.unpack_from("<I", data, at)
        at += 4
        cloud = vectors(points, 3).astype(np.float32)
        origin = vectors(1, 3)[0]
        vectors(1, 4)
        at += 4
        scans.append((cloud, origin))
    return scans


def spherical_scan(folder):
    return DATA / "spherical_scan.graph"


def laser_scan(folder):
    """Return a graph of scan.dat, which contains only points: they are divided into scans with invented origins."""
    with bz2.open(DATA / "scan.dat.bz2", "rt") as file:
        points = np.loadtxt(file)
    log = folder / "scan.log"
    with log.open("w") as file:
        for i, part in enumerate(np.array_split(points, 12)):
            file.write(f"NODE {0.1 * i} {-0.05 * i} 0 0 0 0\n")
            np.savetxt(file, part, fmt="%.9g")
    subprocess.run(["log2graph", log, folder / "scan.graph"], check=True, capture_output=True, timeout=300)
    return folder / "scan.graph"


CASES = [(spherical_scan, 0.1, np.inf), (spherical_scan, 0.3, 2.5), (laser_scan, 0.05, 4.0)]


@pytest.mark.parametrize(("make_graph", "voxel_m", "range_m"), CASES)
def test_maps_of_real_scans_have_the_bytes_of_graph2tree(make_graph, voxel_m, range_m, tmp_path):
    graph = make_graph(tmp_path)
    limit = () if np.isinf(range_m) else ("-m", str(range_m))
    expected = graph2tree(graph, tmp_path, "-res", str(voxel_m), *limit)
    scans = read_graph(graph)

    for engine in ("octomap", "bricks"):
        one_by_one = OccupancyMap(voxel_m, engine=engine)
        for points, origin in scans:
            one_by_one.insert_scan(points, origin, range_m)
        assert (one_by_one.to_bytes("ot"), one_by_one.to_bytes("bt")) == expected

    together = OccupancyMap(voxel_m)
    for first in range(0, len(scans), SCANS_PER_BATCH):
        batch = scans[first : first + SCANS_PER_BATCH]
        clouds, origins = zip(*batch, strict=True)
        together.insert_scans(np.concatenate(clouds), [len(c) for c in clouds], origins, range_m, threads=2)
    assert (together.to_bytes("ot"), together.to_bytes("bt")) == expected
    assert together.statistics().nodes > 300


@pytest.mark.parametrize("engine", ["octomap", "bricks"])
def test_real_map_is_the_same_after_reading(engine, tmp_path):
    occupancy_map = OccupancyMap.read(DATA / "geb079.bt", engine=engine)
    assert occupancy_map.engine == engine
    assert occupancy_map.statistics().occupied_voxels > 10_000
    subprocess.run(
        ["convert_octree", DATA / "geb079.bt", tmp_path / "theirs.ot"], check=True, capture_output=True, timeout=300
    )
    assert occupancy_map.to_bytes("ot") == (tmp_path / "theirs.ot").read_bytes()
    assert (
        occupancy_map.to_bytes("bt").partition(b"\ndata\n")[2]
        == (DATA / "geb079.bt").read_bytes().partition(b"\ndata\n")[2]
    )
