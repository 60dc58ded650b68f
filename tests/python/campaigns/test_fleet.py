"""Fleets: tiles of an area, their surveys, the merged map and its score, all run in this process."""

import json
from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.campaigns.fleet import run_fleet
from uwsim.campaigns.fleet.fleet import shares
from uwsim.campaigns.fleet.score import by_tile
from uwsim.campaigns.fleet.tile_job import TileJob, start_above
from uwsim.campaigns.fleet.tiles import Grid, grid_over, tiles_of
from uwsim.mapping import OccupancyMap
from uwsim.scenario import ScenarioError, build_terrain, load
from uwsim.scenario.spec.survey import area
from uwsim.scoring.map_score import score_map

SQUARE = ((0.0, 0.0), (100.0, 0.0), (100.0, 60.0), (0.0, 60.0))
HORSESHOE = ((0.0, 0.0), (90.0, 0.0), (90.0, 90.0), (60.0, 90.0), (60.0, 30.0), (30.0, 30.0), (30.0, 90.0), (0.0, 90.0))
POOL = """
name: wide_pool
terrain: {source: noise, size_m: [32, 20], spacing_m: 0.5, bed_depth_m: 5, hill_height_m: 0.5, hill_wavelength_m: 9}
station: {position_m: [0, 0, 0]}
vehicles: [{name: rov, model: rov, sonar: {model: 2, tilt_deg: 30}}]
survey: {area_m: [[-6, -2], [6, -2], [6, 2], [-6, 2]], altitude_m: 2, line_spacing_m: 2, speed_m_s: 0.7,
  tilt_deg: 30, voxel_m: 0.5}
"""


@pytest.fixture
def pool(tmp_path: Path) -> Path:
    path = tmp_path / "wide_pool.yaml"
    path.write_text(POOL)
    return path


def test_tiles_cover_the_area_without_overlap_but_for_slivers() -> None:
    for outline in (SQUARE, HORSESHOE):
        grid = grid_over(outline, 40.0)
        tiles, left_m2 = tiles_of(outline, grid, 0.5)
        assert max(grid.edge_m) <= 40.0
        assert sum(area(tile.area_m) for tile in tiles) + left_m2 == pytest.approx(area(outline))
        for tile in tiles:
            middle = np.mean(tile.area_m, axis=0)[None]
            assert tuple(grid.cells_of(middle)[0]) == tile.cell
    outline = ((0.0, 0.0), (10.4, 0.0), (10.4, 10.0), (0.0, 10.0))
    tiles, left_m2 = tiles_of(outline, Grid((0.0, 0.0), (10.0, 10.0), (2, 1)), 0.5)
    assert [area(tile.area_m) for tile in tiles] == pytest.approx([100.0])
    assert left_m2 == pytest.approx(4.0)


def test_a_square_that_the_outline_cuts_in_two_has_two_tiles() -> None:
    grid = Grid((0.0, 40.0), (90.0, 90.0), (1, 1))
    tiles, _ = tiles_of(HORSESHOE, grid, 0.5)
    assert len(tiles) == 2
    places = np.array([[5.0, 80.0, 0.0], [85.0, 80.0, 0.0], [86.0, 80.0, 0.0], [45.0, 80.0, 0.0]], np.float32)
    shared = by_tile(places, grid, tiles)
    assert sorted(len(part) for part in shared.values()) in ([1, 3], [2, 2])  # no point twice


def test_the_fleet_is_out_as_long_as_its_busiest_vehicle() -> None:
    times_s = [5.0, 3.0, 3.0, 2.0, 2.0, 1.0]
    assert shares(times_s, 1) == [16.0]
    assert shares(times_s, 2) == [8.0, 8.0]
    assert max(shares(times_s, 50)) == 5.0


def test_a_part_of_the_terrain_has_the_heights_and_the_water_of_the_whole() -> None:
    whole, low, high = load("lake"), (-30.2, -10.0), (40.0, 25.3)
    full = build_terrain(whole.terrain)
    part = full.window((low, high))
    x0, y0, x1, y1 = part.extent_m
    assert x0 <= low[0] < x0 + part.spacing_m and x1 - part.spacing_m < high[0] <= x1
    assert y0 <= low[1] and high[1] <= y1
    places = np.random.default_rng(0).uniform(low, high, (500, 2))
    np.testing.assert_allclose(part.height_at(places), full.height_at(places), atol=1e-9)
    tile, beside = tiles_of(whole.survey.area_m, grid_over(whole.survey.area_m, 60.0), 0.5)[0][:2]
    starts_m = [start_above(full, each) for each in (tile, beside)]
    assert full.height_at(np.array([start_m[:2] for start_m in starts_m])).max() < -3.5
    first, second = (
        TileJob("lake", 3, {}, voxel_m=0.5, tile=each, start_m=start_m).varied_scenario()
        for each, start_m in zip((tile, beside), starts_m, strict=True)
    )
    assert first.water == second.water and first.vehicles[0].name != second.vehicles[0].name, "noise of its own"
    with Simulator(first) as sim, Simulator(whole) as all_of_it:
        places = np.random.default_rng(1).uniform(np.min(tile.area_m, axis=0), np.max(tile.area_m, axis=0), (500, 2))
        np.testing.assert_allclose(sim.world.height_at(places), all_of_it.world.height_at(places), atol=1e-5)
    with pytest.raises(ScenarioError, match="window_m: is outside the terrain"):
        full.window(((5000.0, 0.0), (6000.0, 10.0)))


OPTIONS = {"tile_m": 6.0, "vehicles": 2, "workers": 0}


def test_a_fleets_map_is_scored_as_one_and_survives_a_stop_and_a_failure(
    pool: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole, again = run_fleet(pool, tmp_path / "whole", **OPTIONS), tmp_path / "part"
    assert (len(whole.tiles), whole.figures["tiles_flown"]) == (2, 2)
    seen: list[int] = []
    watched = {"tell": lambda done, *_: seen.append(done), "stop_requested": lambda: 1 in seen}
    assert run_fleet(pool, again, **OPTIONS, **watched).interrupted and not (again / "map.bt").exists()
    with pytest.raises(ValueError, match="holds a fleet already, 1 tiles of it finished: --resume"):
        run_fleet(pool, again, **OPTIONS)
    with pytest.raises(ValueError, match=r"tile_m is 5\.0: was begun with 6\.0"):
        run_fleet(pool, again, **{**OPTIONS, "tile_m": 5.0}, resume=True)
    with pytest.raises(ValueError, match="--retry-failed: needs --resume"):
        run_fleet(pool, tmp_path / "new", **OPTIONS, retry_failed=True)
    with monkeypatch.context() as patched:
        failing = {"metrics": {}, "error": "ValueError: no"}
        patched.setattr("uwsim.campaigns.fleet.fleet.fly_job", lambda job: failing)
        flown = run_fleet(pool, again, **OPTIONS, resume=True)
        assert flown.failed == {1: "ValueError: no"} and flown.figures["tiles_failed"] == 1
        assert run_fleet(pool, again, **OPTIONS, resume=True).failed
    assert not run_fleet(pool, again, **OPTIONS, resume=True, retry_failed=True).failed
    assert (again / "map.bt").read_bytes() == (tmp_path / "whole" / "map.bt").read_bytes()

    figures = json.loads((tmp_path / "whole" / "summary.json").read_text())
    occupied = OccupancyMap.read(tmp_path / "whole" / "map.bt").occupied_voxels()
    path_m = np.concatenate([np.load(tmp_path / "whole" / "tiles" / f"{k:06d}.npy") for k in range(2)])
    base = load(pool)
    with Simulator(base) as sim:
        score = score_map(sim.world, occupied, 0.5, path_m.astype(float), np.array(base.survey.area_m), 55.0)
    assert figures["occupied_voxels"] == score.occupied_voxels and figures["occupied_voxels_unscored"] == 0
    assert figures["visible_truth_voxels"] == pytest.approx(score.visible_truth_voxels, rel=0.01)
    assert figures["coverage"] == pytest.approx(score.coverage, abs=0.01)
    assert figures["distance_mean_m"] == pytest.approx(score.distance_mean_m, rel=1e-6)
    assert figures["fleet_out_s"] < figures["simulated_s"]


def test_what_makes_no_sense_is_refused_before_anything_is_written(pool: Path, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"tile_m = 0.5 m: must be in \[1, 100000\] m"):
        run_fleet(pool, tmp_path / "out", tile_m=0.5, workers=0)
    pool.write_text(POOL + "faults: [{kind: leak, at_s: 1, kg_per_s: 1}]")
    with pytest.raises(ScenarioError, match="faults: must be left out for a fleet"):
        run_fleet(pool, tmp_path / "out", **OPTIONS)
    assert not (tmp_path / "out").exists()
