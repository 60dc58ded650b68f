"""`uwsim map` on small maps of the pool: info, convert, merge, and errors."""

import json
import subprocess
import sys
from pathlib import Path

import laspy
import numpy as np
import pytest
import rasterio

from pool_maps import VOXEL_M, error_of, uwsim_map, write_pool_maps
from uwsim.mapping import OccupancyMap
from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.difference import map_difference
from uwsim.mapping.files import read_cloud, write_cloud
from uwsim.scoring.survey_track import SurveyTrack


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_pool_maps(tmp_path_factory.mktemp("maps"))


def test_info_describes_the_map(folder):
    occupancy = OccupancyMap.read(folder / "pool.ot")
    for name, kind in (("pool.bt", "bt, occupied or free"), ("pool.ot", "ot, with all probabilities")):
        shown = uwsim_map("info", folder / name)
        assert kind in shown
        assert f"{(folder / name).stat().st_size:,}" in shown
        assert f"{len(occupancy.occupied_voxels()):,} (" in shown
        assert f"{len(occupancy.free_voxels()):,} (" in shown
        assert "0.25 m" in shown
    centres = np.concatenate([occupancy.occupied_voxels(), occupancy.free_voxels()])
    west, east = centres[:, 0].min() - VOXEL_M / 2, centres[:, 0].max() + VOXEL_M / 2
    assert f"known x          {west:.2f} to {east:.2f} m" in shown
    assert "the map is empty" in uwsim_map("info", folder / "empty.bt")
    values = json.loads(uwsim_map("info", folder / "pool.bt", "--json"))
    assert (values["occupied_voxels"], values["resolution_m"]) == (len(occupancy.occupied_voxels()), VOXEL_M)
    assert [values["bounds_m"][0][0], values["bounds_m"][1][0]] == pytest.approx([west, east])
    assert json.loads(uwsim_map("info", folder / "empty.bt", "--json"))["bounds_m"] is None


def test_info_takes_the_format_from_the_first_line_not_the_name(folder, tmp_path):
    (tmp_path / "wrong.bt").write_bytes((folder / "pool.ot").read_bytes())
    assert "ot, with all" in uwsim_map("info", tmp_path / "wrong.bt")


def test_map_formats_convert_into_each_other(folder, tmp_path):
    uwsim_map("convert", folder / "pool.ot", tmp_path / "a.bt")
    assert (tmp_path / "a.bt").read_bytes() == (folder / "pool.bt").read_bytes()
    uwsim_map("convert", folder / "pool.bt", tmp_path / "b.ot")
    uwsim_map("convert", tmp_path / "b.ot", tmp_path / "b.bt")
    assert (tmp_path / "b.bt").read_bytes() == (folder / "pool.bt").read_bytes()


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".xyz", ".las"])
def test_a_map_converts_to_the_cloud_of_its_occupied_voxels(folder, tmp_path, suffix):
    target = tmp_path / f"pool{suffix}"
    shown = uwsim_map("convert", folder / "pool.bt", target, "--origin", "10", "0", "-1")
    centres = OccupancyMap.read(folder / "pool.bt").occupied_voxels()
    assert f"{len(centres):,} points" in shown
    assert read_cloud(target) == pytest.approx(centres + np.array([10.0, 0.0, -1.0]), abs=0.0006)


def test_a_geotiff_holds_median_depth_and_count_from_north_to_south(folder, tmp_path):
    uwsim_map("convert", folder / "pool.bt", tmp_path / "pool.tif", "--cell", "0.5")
    grid = depth_grid(OccupancyMap.read(folder / "pool.bt").occupied_voxels(), 0.5)
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
    uwsim_map("convert", folder / "pool.bt", tmp_path / "pool.tif", "--cell", "0.5")
    assert (tmp_path / "pool.tif").read_bytes() == first


def test_a_geotiff_of_real_terrain_is_placed_on_earth(tmp_path):
    """The valley's origin is at 36.60 N, 84.19 W, and one simulated metre there corresponds to 20 real ones."""
    write_cloud(tmp_path / "bed.ply", [[0.1, 0.1, -20.0], [99.9, 0.1, -21.0]])
    uwsim_map("convert", tmp_path / "bed.ply", tmp_path / "bed.tif", "--cell", "1", "--scenario", "valley")
    with rasterio.open(tmp_path / "bed.tif") as file:
        assert file.transform.a == pytest.approx(20.0)
        longitude, latitude = rasterio.warp.transform(file.crs, "EPSG:4326", [file.transform.c], [file.transform.f])
        assert (longitude[0], latitude[0]) == pytest.approx((-84.19, 36.60 + 20.0 / 111e3), abs=1e-5)
        assert file.width == 100
        assert next(iter(file.sample([(10.0, 10.0)]))).tolist() == [20.0, 1.0]


def test_clouds_of_real_terrain_are_placed_on_earth(tmp_path):
    """laspy and pyproj find the same degrees from easting, northing and WKT as the text has."""
    pyproj = pytest.importorskip("pyproj")
    write_cloud(tmp_path / "bed.ply", [[0.0, 0.0, -20.0], [100.0, 0.0, -21.0], [0.0, 100.0, -22.0]])
    for suffix in ("las", "xyz"):
        uwsim_map("convert", tmp_path / "bed.ply", tmp_path / f"bed.{suffix}", "--scenario", "valley")
    text, las = np.loadtxt(tmp_path / "bed.xyz"), laspy.read(tmp_path / "bed.las")
    crs = las.header.parse_crs()
    longitude, latitude = pyproj.Transformer.from_crs(crs, 4326, always_xy=True).transform(las.x, las.y)
    np.testing.assert_allclose(text, np.column_stack([longitude, latitude, las.z]), atol=2e-8)  # 1 mm
    assert text[0, :2] == pytest.approx((-84.19, 36.60), abs=1e-5)
    assert text[2, 1] - text[0, 1] == pytest.approx(100.0 * 20.0 / 111e3, rel=0.01)
    assert text[:, 2].tolist() == [-20.0, -21.0, -22.0]


def test_cloud_formats_convert_into_each_other(tmp_path):
    points = np.random.default_rng(1).normal(0.0, 10.0, (100, 3)).astype(np.float32)
    write_cloud(tmp_path / "a.pcd", points)
    uwsim_map("convert", tmp_path / "a.pcd", tmp_path / "b.ply")
    assert np.array_equal(read_cloud(tmp_path / "b.ply"), points.astype(np.float64))


def test_a_map_and_its_part_merge_into_a_map_of_the_whole(folder, tmp_path):
    uwsim_map("merge", folder / "part.bt", folder / "pool.bt", "--out", tmp_path / "both.ot")
    uwsim_map("merge", folder / "pool.bt", folder / "part.bt", "--out", tmp_path / "too.ot")
    assert (tmp_path / "both.ot").read_bytes() == (tmp_path / "too.ot").read_bytes()
    found = map_difference(OccupancyMap.read(tmp_path / "both.ot"), OccupancyMap.read(folder / "pool.bt"))
    assert found.counts[:, 2].sum() == 0, "no voxel is known that neither map knew"
    assert found.counts[2].sum() == 0, "no known voxel is lost"
    uwsim_map("merge", folder / "pool.ot", folder / "empty.ot", "--out", tmp_path / "same.ot")
    assert (tmp_path / "same.ot").read_bytes() == (folder / "pool.ot").read_bytes()
    uwsim_map("merge", folder / "pool.ot", folder / "empty.bt", "--out", tmp_path / "same.bt")
    assert (tmp_path / "same.bt").read_bytes() == (folder / "pool.bt").read_bytes()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["info", "no.bt"], r"no.bt"),
        (["info", "torn.bt"], r"torn.bt"),
        (["info", "text.bt"], r"text.bt"),
        (["convert", "pool.bt", "new.e57"], r"target 'new.e57': must end in \.bt, \.ot"),
        (["convert", "cloud.ply", "new.bt"], r"a cloud has no free space, so it cannot become a map"),
        (["convert", "cloud.ply", "new.tif"], r"cell: missing: points have no voxels"),
        (["convert", "pool.bt", "new.tif", "--cell", "-1"], r"--cell = -1.0 m: must be in"),
        (["convert", "pool.bt", "new.tif", "--cell", "1e-9"], r"--cell = 1e-09 m: must be in"),
        (["convert", "pool.bt", "new.tif", "--scenario", "pol"], r"did you mean 'pool'"),
        (["convert", "empty.bt", "new.ply"], r"has no occupied voxels to write"),
        (["convert", "empty.bt", "new.tif"], r"has no occupied voxels to write"),
        (["convert", "torn.ply", "new.pcd"], r"torn.ply': not a valid PLY file"),
        (["convert", "pool.bt", "no/new.ply"], r"no/new.ply': cannot be written: No such file"),
        (["convert", "pool.bt", "no/new.tif"], r"no/new.tif': cannot be written: No such file"),
        (
            ["convert", "pool.bt", "new.ply", "--scenario", "valley"],
            r"--scenario: needs a target that ends in \.las, \.xyz, \.tif",
        ),
        (["convert", "pool.bt", "new.las", "--scenario", "pool"], r"the world has no place on Earth"),
        (["convert", "pool.bt", "new.h5", "--scenario", "pool"], r"an S-102 needs a place on Earth"),
        (["convert", "pool.bt", "new.ot", "--scenario", "valley"], r"--scenario: needs a target that ends in \.las"),
        (["render", "empty.bt"], r"no occupied voxels: there is nothing to draw"),
        (["render", "pool.bt", "--width", "10"], r"width = 10 pixels: must be in \[200, 8000\] pixels"),
        (["render", "pool.bt", "--elevation", "90"], r"elevation = 90.0 deg"),
        (["render", "pool.bt", "--azimuth", "nan"], r"azimuth = nan deg"),
        (["render", "pool.bt", "--out", "new.jpg"], r"figure 'new.jpg': must end in \.png"),
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
        (["slice", "pool.bt", "--z", "nan"], r"z = nan m: must be in"),
        (["slice", "empty.bt", "--z", "0"], r"the map is empty"),
        (["score", "pool.bt", "--scenario", "pol"], r"did you mean 'pool'"),
        (["score", "pool.bt", "--scenario", "pool", "--track", "text.bt"], r"text.bt': not a valid track"),
        (
            ["score", "pool.bt", "--scenario", "pool", "--track", "lake.npz"],
            r"belongs to scenario 'lake', not to 'pool'",
        ),
        (["score", "pool.bt", "--scenario", "pool", "--origin", "0.1", "0", "0"], r"off the grid"),
    ],
)
def test_a_mistake_is_named_and_no_file_is_left(folder, tmp_path, monkeypatch, arguments, message):
    for name in ("pool.bt", "empty.bt", "coarse.bt", "track.npz"):
        (tmp_path / name).write_bytes((folder / name).read_bytes())
    (tmp_path / "torn.bt").write_bytes((folder / "pool.bt").read_bytes()[:-10])
    (tmp_path / "text.bt").write_text("not a map")
    SurveyTrack(np.zeros((1, 3)), np.eye(3)[:, :2], 10.0, "lake").write(tmp_path / "lake.npz")
    write_cloud(tmp_path / "cloud.ply", [[1.0, 2.0, 3.0]])
    (tmp_path / "torn.ply").write_bytes((tmp_path / "cloud.ply").read_bytes()[:-1])
    before = {path.name for path in tmp_path.iterdir()}
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AssertionError, match=message):  # to let pytest search the message
        raise AssertionError(error_of(*arguments))
    assert {path.name for path in tmp_path.iterdir()} == before


def test_the_shell_gets_one_line_and_an_exit_code(folder, tmp_path):
    def uwsim(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", "from uwsim.cli import main; main()", "map", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=600, check=False, cwd=tmp_path)

    broken = uwsim("render", "no.bt")
    assert broken.returncode == 1
    assert broken.stderr.startswith("uwsim: error: ")
    assert len(broken.stderr.strip().splitlines()) == 1
    assert uwsim("rendr").returncode == 2
    assert "info" in uwsim("--help").stdout
    assert "--cell" in uwsim("convert", "--help").stdout
    assert uwsim("diff", str(folder / "pool.bt"), str(folder / "part.bt"), "--exit-code").returncode == 1
    assert not any(tmp_path.iterdir())
