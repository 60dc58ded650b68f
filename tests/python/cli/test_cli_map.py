"""`uwsim map` on small maps of the pool: info, convert, merge, and errors."""

import json

import laspy
import numpy as np
import pytest
import rasterio

from pool_maps import VOXEL_M, error_of, uwsim_map
from uwsim.mapping import OccupancyMap
from uwsim.mapping.changes import map_difference
from uwsim.mapping.depth_grid import depth_grid
from uwsim.mapping.files import read_cloud, write_cloud
from uwsim.scoring.survey_track import SurveyTrack


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


def test_map_formats_convert_into_each_other(folder, tmp_path):
    """The format of the source is that of its first line, not of its name."""
    (tmp_path / "wrong.bt").write_bytes((folder / "pool.ot").read_bytes())
    assert "ot, with all" in uwsim_map("info", tmp_path / "wrong.bt")
    uwsim_map("convert", tmp_path / "wrong.bt", tmp_path / "a.bt")
    uwsim_map("convert", folder / "pool.bt", tmp_path / "b.ot")
    uwsim_map("convert", tmp_path / "b.ot", tmp_path / "b.bt")
    for name in ("a.bt", "b.bt"):
        assert (tmp_path / name).read_bytes() == (folder / "pool.bt").read_bytes()


def test_a_map_converts_to_the_cloud_of_its_occupied_voxels_and_clouds_into_each_other(folder, tmp_path):
    centres = OccupancyMap.read(folder / "pool.bt").occupied_voxels()
    for suffix in (".ply", ".pcd", ".xyz", ".las"):
        target = tmp_path / f"pool{suffix}"
        shown = uwsim_map("convert", folder / "pool.bt", target, "--origin", "10", "0", "-1")
        assert f"{len(centres):,} points" in shown
        assert read_cloud(target) == pytest.approx(centres + np.array([10.0, 0.0, -1.0]), abs=0.0006)
    uwsim_map("convert", tmp_path / "pool.pcd", tmp_path / "again.ply")
    assert np.array_equal(read_cloud(tmp_path / "again.ply"), read_cloud(tmp_path / "pool.pcd"))


def test_a_geotiff_holds_median_depth_and_count_from_north_to_south(folder, tmp_path):
    for name in ("pool.tif", "again.tif"):
        uwsim_map("convert", folder / "pool.bt", tmp_path / name, "--cell", "0.5")
    assert (tmp_path / "pool.tif").read_bytes() == (tmp_path / "again.tif").read_bytes()
    grid = depth_grid(OccupancyMap.read(folder / "pool.bt").occupied_voxels(), 0.5)
    with rasterio.open(tmp_path / "pool.tif") as file:
        assert (file.descriptions, file.units, file.crs) == (("depth", "count"), ("m", None), None)
        assert np.isnan(file.nodata)
        depth, count = file.read()
        assert "mean water surface" in file.tags()["VERTICAL_DATUM"] and file.tags(1)["POSITIVE"] == "down"
        west, east, south, north = grid.extent_m
        assert tuple(file.bounds) == pytest.approx((west, south, east, north))
    assert np.array_equal(depth[::-1], grid.depth_m.astype(np.float32), equal_nan=True)
    assert np.array_equal(count[::-1], grid.count)


def test_grids_and_clouds_of_real_terrain_are_placed_on_earth(tmp_path):
    """The valley's origin is at 36.60 N, 84.19 W, and one simulated metre there corresponds to 20 real ones.

    laspy and pyproj find the same degrees from easting, northing and WKT as the text has.
    """
    pyproj = pytest.importorskip("pyproj")
    write_cloud(tmp_path / "bed.ply", [[0.1, 0.1, -20.0], [99.9, 0.1, -21.0], [0.1, 99.9, -22.0]])
    for name in ("bed.tif", "bed.las", "bed.xyz"):
        cell = ("--cell", "1") if name == "bed.tif" else ()
        uwsim_map("convert", tmp_path / "bed.ply", tmp_path / name, *cell, "--scenario", "valley")
    with rasterio.open(tmp_path / "bed.tif") as file:
        assert file.transform.a == pytest.approx(20.0) and (file.width, file.height) == (100, 100)
        longitude, latitude = rasterio.warp.transform(file.crs, "EPSG:4326", [file.transform.c], [file.transform.f])
        assert (longitude[0], latitude[0]) == pytest.approx((-84.19, 36.60 + 2000.0 / 111e3), abs=1e-4)
        assert next(iter(file.sample([(10.0, 10.0)]))).tolist() == [20.0, 1.0]
    text, las = np.loadtxt(tmp_path / "bed.xyz"), laspy.read(tmp_path / "bed.las")
    crs = las.header.parse_crs()
    longitude, latitude = pyproj.Transformer.from_crs(crs, 4326, always_xy=True).transform(las.x, las.y)
    np.testing.assert_allclose(text, np.column_stack([longitude, latitude, las.z]), atol=2e-8)  # 1 mm
    assert text[0, :2] == pytest.approx((-84.19, 36.60), abs=4e-5)
    assert text[2, 1] - text[0, 1] == pytest.approx(99.8 * 20.0 / 111e3, rel=0.01)
    assert text[:, 2].tolist() == [-20.0, -21.0, -22.0]


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


@pytest.fixture(scope="module")
def mistakes(folder, tmp_path_factory):
    """A folder of maps and clouds, some of them damaged."""
    made = tmp_path_factory.mktemp("mistakes")
    for name in ("pool.bt", "empty.bt", "coarse.bt", "track.npz"):
        (made / name).write_bytes((folder / name).read_bytes())
    (made / "torn.bt").write_bytes((folder / "pool.bt").read_bytes()[:-10])
    (made / "text.bt").write_text("not a map")
    SurveyTrack(np.zeros((1, 3)), np.eye(3)[:, :2], 10.0, "lake").write(made / "lake.npz")
    write_cloud(made / "cloud.ply", [[1.0, 2.0, 3.0]])
    (made / "torn.ply").write_bytes((made / "cloud.ply").read_bytes()[:-1])
    return made


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
        (["convert", "empty.bt", "new.tif"], r"has no occupied voxels to write"),
        (["convert", "torn.ply", "new.pcd"], r"torn.ply': not a valid PLY file"),
        (["convert", "pool.bt", "no/new.ply"], r"no/new.ply': cannot be written: No such file"),
        (["convert", "pool.bt", "new.las", "--scenario", "pool"], r"the world has no place on Earth"),
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
        (["merge", "pool.bt", "coarse.bt", "--out", "new.ot"], r"coarse.bt.*(resolution|0.25|0.5)"),
        (["merge", "pool.bt", "torn.bt", "--out", "new.ot"], r"torn.bt"),
        (["slice", "pool.bt"], r"0 of them given, must be one"),
        (["slice", "pool.bt", "--x", "1", "--z", "-2"], r"2 of them given, must be one"),
        (["slice", "pool.bt", "--z", "50"], r"z = 50 m: must be in \["),
        (["slice", "empty.bt", "--z", "0"], r"the map is empty"),
        (["score", "pool.bt", "--scenario", "pol"], r"did you mean 'pool'"),
        (["score", "pool.bt", "--scenario", "pool", "--track", "text.bt"], r"text.bt': not a valid track"),
        (["score", "pool.bt", "--scenario", "pool", "--track", "lake.npz"], r"belongs to scenario 'lake', not to"),
        (["score", "pool.bt", "--scenario", "pool", "--origin", "0.1", "0", "0"], r"off the grid"),
    ],
)
def test_a_mistake_is_named_and_no_file_is_left(mistakes, monkeypatch, arguments, message):
    before = {path.name for path in mistakes.iterdir()}
    monkeypatch.chdir(mistakes)
    with pytest.raises(AssertionError, match=message):  # to let pytest search the message
        raise AssertionError(error_of(*arguments))
    assert {path.name for path in mistakes.iterdir()} == before
