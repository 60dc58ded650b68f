"""Merging maps: the same bytes in any order; log-odds are summed, states are combined."""

from itertools import permutations
from pathlib import Path

import numpy as np
import pytest

from uwsim.mapping import OccupancyMap
from uwsim.mapping.merge import merge_files

EDGE_M = 0.5
MIN, MAX = (np.float32(np.log(p / (1 - p))) for p in (0.1192, 0.971))


def scanned(seed: int, scans: int = 25) -> OccupancyMap:
    """Return a map of random scans from a few positions, so that maps overlap and contradict each other."""
    random = np.random.default_rng(seed)
    occupancy = OccupancyMap(EDGE_M)
    for _ in range(scans):
        origin = random.uniform(-4, 4, 3)
        points = origin + random.normal(0, 3, (80, 3))
        occupancy.insert_scan(points.astype(np.float32), origin, 20.0)
    return occupancy


def files(folder: Path, suffixes: str) -> list[Path]:
    paths = []
    for seed, suffix in enumerate(suffixes.split()):
        paths.append(folder / f"{seed}{suffix}")
        scanned(seed).write(paths[-1])
    return paths


def known(*maps: OccupancyMap) -> np.ndarray:
    return np.unique(np.concatenate([np.concatenate([m.occupied_voxels(), m.free_voxels()]) for m in maps]), axis=0)


@pytest.mark.parametrize("suffixes", [".ot .ot .ot .ot", ".bt .bt .bt", ".ot .bt .ot"])
@pytest.mark.parametrize("target", ["merged.bt", "merged.ot"])
def test_the_order_does_not_matter(tmp_path: Path, suffixes: str, target: str) -> None:
    paths = files(tmp_path, suffixes)
    contents = set()
    for order in permutations(paths):
        merge_files(order, tmp_path / target)
        contents.add((tmp_path / target).read_bytes())
    assert len(contents) == 1


def test_log_odds_are_summed_and_limited_at_the_end(tmp_path: Path) -> None:
    paths = files(tmp_path, ".ot .ot .ot .ot")
    merge_files(paths, tmp_path / "merged.ot")
    maps, merged = [OccupancyMap.read(path) for path in paths], OccupancyMap.read(tmp_path / "merged.ot")
    places = known(*maps)
    each = np.array([m.log_odds_at(places) for m in maps])
    total = np.nansum(each.astype(np.float64), axis=0)
    np.testing.assert_allclose(merged.log_odds_at(places), np.clip(total, MIN, MAX), atol=1e-5)
    step_by_step = each[0]
    for more in each[1:]:
        step_by_step = np.clip(np.nan_to_num(step_by_step) + np.nan_to_num(more), MIN, MAX)
    assert np.abs(step_by_step - np.clip(total, MIN, MAX)).max() > 0.1, "these maps do not tell the rules apart"


@pytest.mark.parametrize("suffixes", [".bt .bt .bt", ".ot .bt .ot"])
def test_a_voxel_is_occupied_if_any_map_has_it_so(tmp_path: Path, suffixes: str) -> None:
    paths = files(tmp_path, suffixes)
    count = merge_files(paths, tmp_path / "merged.bt")
    maps, merged = [OccupancyMap.read(path) for path in paths], OccupancyMap.read(tmp_path / "merged.bt")
    places = known(*maps)
    states = np.array([m.state_at(places) for m in maps])
    np.testing.assert_array_equal(merged.state_at(places), states.max(axis=0))
    assert count == (states.max(axis=0) == 1).sum()
    assert ((states == 0).any(axis=0) & (states == 1).any(axis=0)).any(), "these maps never disagree"


def test_many_that_see_water_do_not_outvote_one_that_sees_the_bed(tmp_path: Path) -> None:
    bed = OccupancyMap(EDGE_M)
    bed.insert_scan(np.array([[5.0, 0.0, 0.0]], np.float32), [0.0, 0.0, 0.0])
    bed.write(tmp_path / "bed.bt")
    water = OccupancyMap(EDGE_M)
    water.insert_scan(np.array([[9.0, 0.0, 0.0]], np.float32), [0.0, 0.0, 0.0])
    paths = [tmp_path / "bed.bt"]
    for k in range(20):
        paths.append(tmp_path / f"water{k}.bt")
        water.write(paths[-1])
    merge_files(paths, tmp_path / "merged.bt")
    assert OccupancyMap.read(tmp_path / "merged.bt").state_at([[5.0, 0.0, 0.0]]) == 1
