"""Both map engines produce the same bytes from the same scans, whatever the batch size."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

from uwsim.mapping import OccupancyMap

BENCH = Path(__file__).parents[3] / "tools" / "bench" / "mapping.py"
RANGE_M = 25.0


def pings(count=12, seed=5):
    """Return scans of a wavy floor, with some missing echoes: points (n, 3) float32, counts (m,), origins (m, 3)."""
    random = np.random.default_rng(seed)
    clouds, origins = [], []
    for ping in range(count):
        beams = int(random.integers(0, 120))
        x = 0.3 * ping + random.uniform(-12, 12, beams)
        y = random.uniform(-20, 20, beams)
        cloud = np.column_stack([x, y, -8 + np.sin(x / 3)]).astype(np.float32)
        cloud[random.random(beams) < 0.05] = np.nan
        clouds.append(cloud)
        origins.append([0.3 * ping, 0.0, 0.0])
    return np.concatenate(clouds), np.array([len(cloud) for cloud in clouds]), np.array(origins)


def both(occupancy_map):
    return occupancy_map.to_bytes("ot"), occupancy_map.to_bytes("bt")


@pytest.fixture(scope="module")
def reference():
    points, counts, origins = pings()
    occupancy_map = OccupancyMap(0.2, engine="octomap")
    for part, origin in zip(np.split(points, np.cumsum(counts)[:-1]), origins, strict=True):
        occupancy_map.insert_scan(part, origin, RANGE_M)
    assert occupancy_map.statistics().occupied_voxels > 300
    return occupancy_map


@pytest.mark.parametrize(("batch", "threads"), [(1, 1), (5, 2), (12, 1), (12, 3)])
def test_bricks_give_the_bytes_of_the_reference(reference, batch, threads):
    points, counts, origins = pings()
    ends = np.cumsum(counts)
    occupancy_map = OccupancyMap(0.2)
    for first in range(0, len(counts), batch):
        cut = slice(first, min(first + batch, len(counts)))
        rows = points[ends[first] - counts[first] : ends[cut.stop - 1]]
        occupancy_map.insert_scans(rows, counts[cut], origins[cut], RANGE_M, threads=threads)
    assert both(occupancy_map) == both(reference)
    np.testing.assert_array_equal(occupancy_map.occupied_voxels(), reference.occupied_voxels())
    np.testing.assert_array_equal(occupancy_map.free_voxels(), reference.free_voxels())
    where = np.random.default_rng(1).uniform(-25, 25, (500, 3))
    np.testing.assert_array_equal(occupancy_map.state_at(where), reference.state_at(where))


def test_one_more_miss_changes_the_bytes(reference):
    points, counts, origins = pings()
    occupancy_map = OccupancyMap(0.2)
    occupancy_map.insert_scans(points, counts, origins, RANGE_M)
    occupancy_map.insert_scan([[0.5, 0.5, -3.0]], origins[0], RANGE_M)
    assert occupancy_map.to_bytes("ot") != reference.to_bytes("ot")


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        ({"engine": "bonxai"}, "map.engine = 'bonxai': must be one of bricks, octomap"),
        ({"instruction_set": "mmx"}, "map.instruction_set = 'mmx'"),
        ({"on_outside": "lose"}, r"map\.on_outside = 'lose': must be one of raise, count"),
        ({"hit": 0.3}, r"map\.hit = 0\.3: must be in \[0\.5, 1\)"),
        ({"miss": 0.0}, r"map\.miss = 0: must be in"),
        ({"clamping": (0.9, 0.1)}, "must be greater than map.clamping_min"),
    ],
)
def test_invalid_options_are_refused(options, rule):
    with pytest.raises(ValueError, match=rule):
        OccupancyMap(0.5, **options)


@pytest.mark.parametrize(
    ("points", "counts", "origins", "rule"),
    [
        ([[1, 0, 0]], [2], [[0, 0, 0]], r"scans\.counts\[0\] = 2: must add up"),
        ([[1, 0, 0]], [0], [[0, 0, 0]], "scans.counts = 0: must add up"),
        ([[1, 0, 0]], [-1, 2], [[0, 0, 0]] * 2, r"scans\.counts\[0\] = -1"),
        ([[1, 0, 0]], [0.5], [[0, 0, 0]], "must be whole numbers"),
        ([[1, 0, 0]], [np.nan], [[0, 0, 0]], "must be whole numbers"),
        ([[1, 0, 0]], [np.inf], [[0, 0, 0]], "must be whole numbers"),
        ([[1, 0, 0]], [1], [[0, 0, 0]] * 2, "must be x, y, z for each count"),
        ([[1, 0, 0]], [1], [[0, 0]], r"expected \(n, 3\)"),
        ([[1, 0, 0], [1e7, 0, 0]], [1, 1], [[0, 0, 0]] * 2, "must be within"),
    ],
)
def test_batch_is_inserted_whole_or_not_at_all(points, counts, origins, rule):
    occupancy_map = OccupancyMap()
    with pytest.raises(ValueError, match=rule):
        occupancy_map.insert_scans(points, counts, origins)
    assert occupancy_map.statistics().nodes == 0
    occupancy_map.insert_scans(np.empty((0, 3)), [], np.empty((0, 3)))
    occupancy_map.insert_scans(np.empty((0, 3)), [0, 0], np.zeros((2, 3)))
    assert occupancy_map.statistics().nodes == 0


def test_the_bench_measures_every_case(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(BENCH.parent)
    spec = importlib.util.spec_from_file_location("bench_mapping", BENCH)
    bench = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(bench)
    work = bench.Workload(65, 120, 40, 30, {})
    scans = bench.Seabed().scans(work, 4)
    assert scans.points_m.shape == (4 * 65, 3)
    figures = bench.measure("small", bench.make_cases(scans, 0.5, tmp_path), rounds=1)
    for case in ("bricks_1", "bricks_2", "one_by_one", "portable", "stock_lazy"):
        assert figures[f"{case}_ms"] > 0
        assert figures[f"{case}_ratio"] > 0
    memory = bench.peak_memory(work, 4, 0.5)
    assert memory["octomap_mb"] > 0
