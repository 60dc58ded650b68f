"""`uwsim map` on a small map of the pool: what it writes, what it counts, what it refuses."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import rasterio
from PIL import Image
from typer.testing import CliRunner

from uwsim import _core
from uwsim.cloud_files import read_cloud, write_cloud
from uwsim.mapping import OccupancyMap
from uwsim.maps.cli import app
from uwsim.maps.compare import difference
from uwsim.maps.slices import slice_map
from uwsim.scenario import build_world, load
from uwsim.scenario.paths import assets_folder
from uwsim.survey.seabed import seabed_grid
from uwsim.survey.track import Track

VOXEL_M, RANGE_M = 0.25, 5.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """pool.bt, pool.ot and track.npz of a sonar that looked down everywhere; part.bt, which saw only a part."""
    folder = tmp_path_factory.mktemp("maps")
    scenario = load("pool")
    rays = _core.RayScene(build_world(scenario))
    area = np.asarray(scenario.survey.area_m)
    low, high = area.min(axis=0), area.max(axis=0)
    places = [(x, y, -1.5) for x in np.linspace(low[0], high[0], 9) for y in np.linspace(low[1], high[1], 9)]
    whole, part = OccupancyMap(VOXEL_M), OccupancyMap(VOXEL_M)
    random = np.random.default_rng(3)
    for index, place in enumerate(places):
        ways = random.normal(0.0, 1.0, (3000, 3)) * [1.0, 1.0, 0.5] - [0.0, 0.0, 1.0]
        ranges = rays.cast(np.array([place]), ways, RANGE_M).ranges_m
        hit = np.isfinite(ranges)
        unit = ways / np.linalg.norm(ways, axis=1)[:, None]
        points = (np.array(place) + unit[hit] * ranges[hit, None]).astype(np.float32)
        whole.insert_scan(points, place, RANGE_M)
        if index < 30:
            part.insert_scan(points, place, RANGE_M)
    whole.write(folder / "pool.bt")
    whole.write(folder / "pool.ot")
    part.write(folder / "part.bt")
    OccupancyMap(VOXEL_M).write(folder / "empty.bt")
    OccupancyMap(0.5).write(folder / "coarse.bt")
    Track(np.array(places), area, RANGE_M).write(folder / "track.npz")
    return folder


def run(*arguments: object) -> str:
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert result.exit_code == 0, result.output
    return result.stdout


def refused(*arguments: object) -> str:
    """The message of what the command line shows as one line."""
    result = CliRunner().invoke(app, [str(argument) for argument in arguments])
    assert isinstance(result.exception, ValueError | OSError), result.output
    return str(result.exception)


def picture(path: Path) -> np.ndarray:
    image = np.asarray(Image.open(path).convert("RGB"))
    assert image.std() > 5.0, "not one colour all over"
    return image


def test_info_tells_what_the_map_holds(folder):
    occupancy = OccupancyMap.read(folder / "pool.ot")
    for name, kind in (("pool.bt", "bt, occupied or free"), ("pool.ot", "ot, with all probabilities")):
        shown = run("info", folder / name)
        assert kind in shown
        assert f"{(folder / name).stat().st_size:,}" in shown
        assert f"{len(occupancy.occupied_voxels()):,} (" in shown
        assert f"{len(occupancy.free_voxels()):,} (" in shown
        assert "0.25 m" in shown
    centres = np.concatenate([occupancy.occupied_voxels(), occupancy.free_voxels()])
    west, east = centres[:, 0].min() - VOXEL_M / 2, centres[:, 0].max() + VOXEL_M / 2
    assert f"known x          {west:.2f} to {east:.2f} m" in shown
    assert "the map is empty" in run("info", folder / "empty.bt")


def test_info_goes_by_the_files_first_line_and_not_by_its_name(folder, tmp_path):
    (tmp_path / "wrong.bt").write_bytes((folder / "pool.ot").read_bytes())
    assert "ot, with all" in run("info", tmp_path / "wrong.bt")


def test_maps_convert_into_each_other(folder, tmp_path):
    run("convert", folder / "pool.ot", tmp_path / "a.bt")
    assert (tmp_path / "a.bt").read_bytes() == (folder / "pool.bt").read_bytes()
    run("convert", folder / "pool.bt", tmp_path / "b.ot")
    run("convert", tmp_path / "b.ot", tmp_path / "b.bt")
    assert (tmp_path / "b.bt").read_bytes() == (folder / "pool.bt").read_bytes()


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".xyz", ".las"])
def test_a_map_becomes_the_cloud_of_its_occupied_voxels(folder, tmp_path, suffix):
    target = tmp_path / f"pool{suffix}"
    shown = run("convert", folder / "pool.bt", target, "--origin", "10", "0", "-1")
    centres = OccupancyMap.read(folder / "pool.bt").occupied_voxels()
    assert f"{len(centres):,} points" in shown
    assert read_cloud(target) == pytest.approx(centres + np.array([10.0, 0.0, -1.0]), abs=0.0006)


def test_a_geotiff_holds_median_depth_and_count_from_north_to_south(folder, tmp_path):
    run("convert", folder / "pool.bt", tmp_path / "pool.tif", "--cell", "0.5")
    grid = seabed_grid(OccupancyMap.read(folder / "pool.bt").occupied_voxels(), 0.5)
    with rasterio.open(tmp_path / "pool.tif") as file:
        assert file.descriptions == ("depth", "count")
        assert file.units == ("m", None)
        assert file.crs is None
        assert np.isnan(file.nodata)
        depth, count = file.read()
        assert "mean water surface" in file.tags()["VERTICAL_DATUM"]
        assert file.tags(1)["POSITIVE"] == "down"
        west, east, south, north = grid.extent_m
        assert tuple(file.bounds) == pytest.approx((west, south, east, north))
        row, column = file.index(0.26, 0.26)
    assert np.array_equal(depth[::-1], grid.depth_m.astype(np.float32), equal_nan=True)
    assert np.array_equal(count[::-1], grid.count)
    assert depth[row, column] == pytest.approx(grid.depth_m[int((0.26 - south) / 0.5), int((0.26 - west) / 0.5)])
    first = (tmp_path / "pool.tif").read_bytes()
    run("convert", folder / "pool.bt", tmp_path / "pool.tif", "--cell", "0.5")
    assert (tmp_path / "pool.tif").read_bytes() == first


def test_a_geotiff_of_real_terrain_lies_on_earth(tmp_path):
    """The valley's origin is at 36.60 N, 84.19 W, and a simulated metre there is 20 real ones."""
    write_cloud(tmp_path / "bed.ply", [[0.1, 0.1, -20.0], [99.9, 0.1, -21.0]])
    run("convert", tmp_path / "bed.ply", tmp_path / "bed.tif", "--cell", "1", "--scenario", "valley")
    with rasterio.open(tmp_path / "bed.tif") as file:
        assert file.transform.a == pytest.approx(20.0)
        longitude, latitude = rasterio.warp.transform(file.crs, "EPSG:4326", [file.transform.c], [file.transform.f])
        assert (longitude[0], latitude[0]) == pytest.approx((-84.19, 36.60 + 20.0 / 111e3), abs=1e-5)
        assert file.width == 100
        assert next(iter(file.sample([(10.0, 10.0)]))).tolist() == [20.0, 1.0]


def test_clouds_convert_into_each_other(tmp_path):
    points = np.random.default_rng(1).normal(0.0, 10.0, (100, 3)).astype(np.float32)
    write_cloud(tmp_path / "a.pcd", points)
    run("convert", tmp_path / "a.pcd", tmp_path / "b.ply")
    assert np.array_equal(read_cloud(tmp_path / "b.ply"), points.astype(np.float64))


def test_the_score_of_a_good_map_is_good_and_of_a_part_is_not(folder, tmp_path):
    shown = run(
        "score", folder / "pool.bt", "--scenario", "pool", "--out", tmp_path / "s.png", "--json", tmp_path / "s"
    )
    whole = json.loads((tmp_path / "s").read_text())
    assert whole["coverage"] > 0.98
    assert whole["precision"] > 0.99
    assert whole["recall"] > 0.9
    assert whole["distance_p95_m"] < VOXEL_M
    assert whole["s44_order"] == "Exclusive"
    assert whole["s44_share_2"] == 1.0
    assert "precision of occupied voxels" in shown
    picture(tmp_path / "s.png")
    run("score", folder / "part.bt", "--scenario", "pool", "--out", tmp_path / "p.png", "--json", tmp_path / "p")
    assert json.loads((tmp_path / "p").read_text())["coverage"] < 0.9


@pytest.mark.parametrize(("raised_m", "order"), [(0.5, "2"), (1.0, None)])
def test_a_map_that_lies_too_high_is_off_by_that_and_of_a_lesser_order(folder, tmp_path, raised_m, order):
    options = ("--scenario", "pool", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json")
    run("score", folder / "pool.bt", *options)
    placed = json.loads((tmp_path / "s.json").read_text())
    run("score", folder / "pool.bt", *options, "--origin", "0", "0", raised_m)
    raised = json.loads((tmp_path / "s.json").read_text())
    assert abs(placed["seabed_error_mean_m"]) <= VOXEL_M / 2 + 0.01
    assert raised["seabed_error_mean_m"] - placed["seabed_error_mean_m"] == pytest.approx(-raised_m)
    assert (placed["s44_order"], raised["s44_order"]) == ("Exclusive", order)
    assert raised["precision"] < 0.1


def test_without_a_track_the_score_says_what_it_does_not_know(folder, tmp_path):
    (tmp_path / "map.bt").write_bytes((folder / "pool.bt").read_bytes())
    shown = run("score", tmp_path / "map.bt", "--scenario", "pool", "--json", tmp_path / "s.json")
    assert "no track of the survey" in shown
    alone = json.loads((tmp_path / "s.json").read_text())
    assert alone["coverage"] is None
    assert alone["precision"] > 0.99
    assert (tmp_path / "map.score.png").exists()
    write_cloud(tmp_path / "flown.xyz", Track.read(folder / "track.npz").path_world_m)
    run("score", tmp_path / "map.bt", "--scenario", "pool", "--track", tmp_path / "flown.xyz", "--json", tmp_path / "j")
    assert json.loads((tmp_path / "j").read_text())["coverage"] > 0.98


def test_an_empty_map_is_scored_too(folder, tmp_path):
    run("score", folder / "empty.bt", "--scenario", "pool", "--out", tmp_path / "s.png", "--json", tmp_path / "s.json")
    empty = json.loads((tmp_path / "s.json").read_text())
    assert (empty["coverage"], empty["precision"], empty["distance_mean_m"]) == (0.0, None, None)


def test_a_difference_counts_every_voxel_once(folder, tmp_path):
    whole, part = OccupancyMap.read(folder / "pool.bt"), OccupancyMap.read(folder / "part.bt")
    found = difference(whole, part)
    counts = {
        name: (m.statistics().occupied_voxels, m.statistics().free_voxels) for name, m in (("w", whole), ("p", part))
    }
    assert tuple(found.counts[:2].sum(axis=1)) == counts["w"]
    assert tuple(found.counts[:, :2].sum(axis=0)) == counts["p"]
    assert found.counts[0, 2] > 0
    assert len(found.only_first_m) == found.counts[0, 1:].sum()
    assert len(found.only_second_m) == found.counts[1:, 0].sum()
    assert len(found.both_m) == found.counts[0, 0]
    assert np.array_equal(difference(part, whole).counts, found.counts.T)
    shown = run("diff", folder / "pool.bt", folder / "part.bt", "--out", tmp_path / "d.png")
    assert f"{found.differing:,} voxels differ" in shown
    picture(tmp_path / "d.png")


def test_a_map_and_itself_do_not_differ_and_the_exit_code_says_so(folder):
    runner = CliRunner()
    same = ["diff", str(folder / "pool.bt"), str(folder / "pool.ot"), "--exit-code"]
    assert "the states of all voxels are the same" in run(*same)
    other = [*same[:2], str(folder / "part.bt"), "--exit-code"]
    assert runner.invoke(app, other).exit_code == 1
    assert runner.invoke(app, other[:-1]).exit_code == 0


def test_maps_of_parts_merge_into_the_map_of_the_whole(folder, tmp_path):
    run("merge", folder / "part.bt", folder / "pool.bt", "--out", tmp_path / "both.ot")
    run("merge", folder / "pool.bt", folder / "part.bt", "--out", tmp_path / "too.ot")
    assert (tmp_path / "both.ot").read_bytes() == (tmp_path / "too.ot").read_bytes()
    found = difference(OccupancyMap.read(tmp_path / "both.ot"), OccupancyMap.read(folder / "pool.bt"))
    assert found.counts[:, 2].sum() == 0, "nothing is known that neither knew"
    assert found.counts[2].sum() == 0, "nothing is forgotten"
    run("merge", folder / "pool.ot", folder / "empty.bt", "--out", tmp_path / "same.ot")
    assert (tmp_path / "same.ot").read_bytes() == (folder / "pool.ot").read_bytes()


@pytest.mark.parametrize("axis", ["x", "y", "z"])
def test_a_cut_holds_the_states_of_its_layer(folder, tmp_path, axis):
    occupancy = OccupancyMap.read(folder / "pool.bt")
    at = {"x": 0.1, "y": -1.0, "z": -4.6}[axis]
    cut = slice_map(occupancy, axis, at)
    normal = "xyz".index(axis)
    assert abs(cut.at_m - at) <= VOXEL_M / 2 + 1e-9
    for voxels, state in ((occupancy.occupied_voxels(), 1), (occupancy.free_voxels(), 0)):
        assert np.count_nonzero(cut.states == state) == np.count_nonzero(np.abs(voxels[:, normal] - cut.at_m) < 0.01)
    west, _, south, _ = cut.extent_m
    inside = occupancy.occupied_voxels()
    inside = np.delete(inside[np.abs(inside[:, normal] - cut.at_m) < 0.01], normal, axis=1)
    columns, rows = np.floor((inside - [west, south]) / VOXEL_M).astype(int).T
    assert (cut.states[rows, columns] == 1).all()
    run("slice", folder / "pool.bt", f"--{axis}", at, "--out", tmp_path / "c.png")
    picture(tmp_path / "c.png")


def test_a_rendering_shows_the_map_in_colour_and_is_the_same_twice(folder, tmp_path):
    for name in ("a.png", "b.png"):
        run("render", folder / "pool.bt", "--out", tmp_path / name, "--width", "400")
    image = picture(tmp_path / "a.png")
    assert image.shape[1] >= 380
    assert (np.ptp(image.astype(int), axis=2) > 60).mean() > 0.1, "the cubes are in colour"
    assert (tmp_path / "a.png").read_bytes() == (tmp_path / "b.png").read_bytes()


def test_a_map_of_too_many_cubes_is_drawn_in_larger_ones(folder, tmp_path, monkeypatch):
    from uwsim.maps import render

    monkeypatch.setattr(render, "MAX_CUBES", 500)
    centres, edge_m = render._cubes(OccupancyMap.read(folder / "pool.bt", (0.1, 0.2, 0.3)))
    assert len(centres) <= 500
    assert edge_m > VOXEL_M
    run("render", folder / "pool.bt", "--out", tmp_path / "a.png", "--width", "300")
    picture(tmp_path / "a.png")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["info", "no.bt"], r"no.bt"),
        (["info", "torn.bt"], r"torn.bt"),
        (["info", "text.bt"], r"text.bt"),
        (["convert", "pool.bt", "new.e57"], r"target 'new.e57': must end in \.bt, \.ot"),
        (["convert", "cloud.ply", "new.bt"], r"a cloud does not say what is free"),
        (["convert", "cloud.ply", "new.tif"], r"cell: a cloud has no voxels"),
        (["convert", "pool.bt", "new.tif", "--cell", "-1"], r"cell_m = -1.0 m: must be positive"),
        (["convert", "pool.bt", "new.tif", "--cell", "1e-9"], r"cell_m = 1e-09 m: makes"),
        (["convert", "pool.bt", "new.tif", "--scenario", "pol"], r"did you mean 'pool'"),
        (["convert", "empty.bt", "new.ply"], r"has no occupied voxels to write"),
        (["convert", "empty.bt", "new.tif"], r"has no occupied voxels to write"),
        (["convert", "torn.ply", "new.pcd"], r"torn.ply': not a sound PLY file"),
        (["convert", "pool.bt", "no/new.ply"], r"no/new.ply': cannot be written: No such file"),
        (["convert", "pool.bt", "no/new.tif"], r"no/new.tif': cannot be written: No such file"),
        (["render", "empty.bt"], r"no occupied voxel: there is nothing to draw"),
        (["render", "pool.bt", "--width", "10"], r"width = 10: must be in \[200, 8000\] pixels"),
        (["render", "pool.bt", "--elevation", "90"], r"elevation = 90 deg"),
        (["render", "pool.bt", "--azimuth", "nan"], r"azimuth = nan deg"),
        (["render", "pool.bt", "--out", "new.jpg"], r"picture 'new.jpg': must end in \.png"),
        (["diff", "pool.bt", "coarse.bt"], r"resolution_m = 0.25 and 0.5 m: must be the same"),
        (["diff", "empty.bt", "empty.bt", "--out", "new.png"], r"nothing to draw"),
        (["merge", "pool.bt", "--out", "new.ot"], r"1 maps? given: must be two or more"),
        (["merge", "pool.bt", "pool.bt", "--out", "new.ply"], r"'new.ply': must end in \.bt or \.ot"),
        (
            ["merge", "pool.bt", "coarse.bt", "--out", "new.ot"],
            r"coarse.bt.*(resolution|0.25|0.5)",
        ),
        (["merge", "pool.bt", "torn.bt", "--out", "new.ot"], r"torn.bt"),
        (["slice", "pool.bt"], r"0 of them given, must be one"),
        (["slice", "pool.bt", "--x", "1", "--z", "-2"], r"2 of them given, must be one"),
        (["slice", "pool.bt", "--z", "50"], r"z = 50 m: must be in \["),
        (["slice", "pool.bt", "--z", "nan"], r"z = nan m: must be finite"),
        (["slice", "empty.bt", "--z", "0"], r"the map is empty"),
        (["score", "pool.bt", "--scenario", "pol"], r"did you mean 'pool'"),
        (["score", "pool.bt", "--scenario", "pool", "--track", "text.bt"], r"text.bt': not a sound track"),
        (["score", "pool.bt", "--scenario", "pool", "--track", "lake.npz"], r"is of scenario 'lake', not of 'pool'"),
        (["score", "pool.bt", "--scenario", "pool", "--origin", "0.1", "0", "0"], r"off the grid"),
    ],
)
def test_a_mistake_is_named_and_leaves_nothing(folder, tmp_path, monkeypatch, arguments, message):
    for name in ("pool.bt", "empty.bt", "coarse.bt", "track.npz"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "torn.bt").write_bytes((folder / "pool.bt").read_bytes()[:-10])
    (tmp_path / "text.bt").write_text("no map at all")
    Track(np.zeros((1, 3)), np.eye(3)[:, :2], 10.0, "lake").write(tmp_path / "lake.npz")
    write_cloud(tmp_path / "cloud.ply", [[1.0, 2.0, 3.0]])
    (tmp_path / "torn.ply").write_bytes((tmp_path / "cloud.ply").read_bytes()[:-1])
    before = {path.name for path in tmp_path.iterdir()}
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match=message):  # re.search by pytest
        raise AssertionError(refused(*arguments))
    assert {path.name for path in tmp_path.iterdir()} == before


def test_the_shell_sees_one_line_and_an_exit_code(folder, tmp_path):
    def uwsim(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", "from uwsim.cli import main; main()", "map", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, cwd=tmp_path)

    broken = uwsim("render", "no.bt")
    assert broken.returncode == 1
    assert broken.stderr.startswith("uwsim: error: ")
    assert len(broken.stderr.strip().splitlines()) == 1
    assert uwsim("rendr").returncode == 2
    assert "info" in uwsim("--help").stdout
    assert "--cell" in uwsim("convert", "--help").stdout
    assert uwsim("diff", str(folder / "pool.bt"), str(folder / "part.bt"), "--exit-code").returncode == 1
    assert not any(tmp_path.iterdir())


def test_a_track_comes_back_and_a_broken_one_is_refused(tmp_path):
    path = tmp_path / "track.npz"
    track = Track(np.random.default_rng(0).normal(size=(50, 3)), np.array([[0.0, 0], [1, 0], [0, 1]]), 54.9, "pool")
    track.write(path)
    back = Track.read(path)
    assert np.array_equal(back.path_world_m, track.path_world_m)
    assert np.array_equal(back.area_world_m, track.area_world_m)
    assert (back.range_max_m, back.scenario_name) == (54.9, "pool")
    whole = path.read_bytes()
    track.write(path)
    assert path.read_bytes() == whole
    random = np.random.default_rng(1)
    for trial in range(60):
        data = bytearray(whole)
        if trial % 2:
            del data[random.integers(len(data)) :]
        else:
            data[random.integers(len(data))] ^= 0xFF
        path.write_bytes(bytes(data))
        try:
            Track.read(path)
        except ValueError as error:
            assert "not a sound track" in str(error)
    for bad in (
        Track(np.full((2, 3), np.nan), track.area_world_m, 10.0),
        Track(np.zeros((2, 2)), track.area_world_m, 10.0),
        Track(np.zeros((2, 3)), track.area_world_m[:2], 10.0),
        Track(np.zeros((2, 3)), track.area_world_m, -1.0),
    ):
        bad.write(path)
        with pytest.raises(ValueError, match="not a sound track"):
            Track.read(path)


def test_the_packaged_pool_still_has_a_survey_to_score():
    assert "survey:" in (assets_folder() / "scenarios" / "pool.yaml").read_text()
