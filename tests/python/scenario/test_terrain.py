"""Terrain passes through the points of its source data, in metres, without gaps."""

import socket
from pathlib import Path

import numpy as np
import pytest
import rasterio
from PIL import Image
from rasterio.transform import from_origin

from uwsim.scenario import ScenarioError, build_terrain
from uwsim.scenario.build.terrain import Terrain
from uwsim.scenario.terrains.image import ImageTerrain
from uwsim.scenario.terrains.noise import NoiseTerrain, Rim
from uwsim.scenario.terrains.raster import RasterTerrain

RNG = np.random.default_rng(3)
GRID = RNG.integers(200, 300, (12, 15)).astype(np.float64)  # rows from north to south


def write_asc(path: Path, values: np.ndarray, cell: float = 10.0, corner: tuple[float, float] = (1000, 2000)) -> Path:
    ny, nx = values.shape
    header = f"ncols {nx}\nnrows {ny}\nxllcorner {corner[0]!r}\nyllcorner {corner[1]!r}\ncellsize {cell!r}\n"
    path.write_text(
        header + "NODATA_value -9999\n" + "\n".join(" ".join(f"{v:g}" for v in row) for row in values) + "\n"
    )
    return path


def write_tif(
    path: Path, values: np.ndarray, crs: str | None, cell: float = 10.0, nodata: float | None = None,
    at: tuple[float, float] = (500_000, 4_000_000),
) -> Path:  # fmt: skip
    bands = np.atleast_3d(values.T).T if values.ndim == 2 else values
    with rasterio.open(
        path, "w", driver="GTiff", count=len(bands), height=bands.shape[1], width=bands.shape[2], dtype="float32",
        crs=crs, transform=from_origin(*at, cell, cell), nodata=nodata,
    ) as file:  # fmt: skip
        file.write(bands.astype("float32"))
    return path


def raster(file: Path, **settings: object) -> RasterTerrain:
    return RasterTerrain.model_validate(
        {"source": "raster", "file": file, "water_level_m": 250, "spacing_m": 10, "size_m": [140, 110], **settings}
    )


@pytest.mark.parametrize("interpolation", ["cubic", "linear"])
def test_heights_equal_a_metric_raster_at_its_cell_centres(interpolation: str, tmp_path: Path) -> None:
    for file in (write_asc(tmp_path / "a.asc", GRID), write_tif(tmp_path / "b.tif", GRID, "EPSG:32616")):
        terrain = build_terrain(raster(file, interpolation=interpolation, vertical_scale=0.5))
        assert terrain.origin_m == (-70.0, -55.0)
        np.testing.assert_allclose(terrain.heights_m, (GRID[::-1] - 250) / 2, atol=1e-5)


def test_a_finer_grid_passes_through_the_cells_of_a_scaled_raster(tmp_path: Path) -> None:
    file = write_asc(tmp_path / "a.asc", GRID)
    terrain = build_terrain(raster(file, horizontal_scale=0.1, spacing_m=0.25, size_m=[14, 11]))
    assert terrain.extent_m == (-7.0, -5.5, 7.0, 5.5)
    np.testing.assert_allclose(terrain.heights_m[::4, ::4], GRID[::-1] - 250, atol=1e-4)


def test_the_default_size_is_that_of_the_largest_grid_that_fits(tmp_path: Path) -> None:
    terrain = build_terrain(raster(write_asc(tmp_path / "a.asc", GRID), size_m=None))
    np.testing.assert_allclose(terrain.heights_m, GRID[::-1] - 250, atol=1e-4)


def test_feet_are_converted_to_metres(tmp_path: Path) -> None:
    file = write_tif(tmp_path / "feet.tif", GRID, "EPSG:2274", at=(2e6, 6e5))  # Tennessee, US survey feet
    terrain = build_terrain(raster(file, size_m=None, spacing_m=1.0, unit="m"))
    width_m = terrain.extent_m[2] - terrain.extent_m[0]
    assert width_m == pytest.approx(140 * 1200 / 3937, abs=1.0)


@pytest.mark.parametrize("latitude", [36.0, -60.0])
def test_a_degree_grid_has_cells_of_the_right_metric_size(latitude: float, tmp_path: Path) -> None:
    """A cell spans a cos(lat) / sqrt(1 - e2 sin2) dlon across and a (1 - e2) / (1 - e2 sin2)^1.5 dlat up (WGS 84)."""
    a, e2, cell = 6378137.0, 0.00669437999014, 0.001
    flattening = 1 - e2 * np.sin(np.radians(latitude)) ** 2
    east_m = a * np.cos(np.radians(latitude)) / np.sqrt(flattening) * np.radians(cell)
    north_m = a * (1 - e2) / flattening**1.5 * np.radians(cell)
    columns, rows = np.meshgrid(np.arange(21), np.arange(21))
    for values, metres in ((columns, east_m), (20 - rows, north_m)):
        file = write_asc(tmp_path / "a.asc", values.astype(float), cell, (-84.0, latitude - 10.5 * cell))
        heights = build_terrain(
            raster(file, water_level_m=0, spacing_m=10, size_m=[800, 1600], interpolation="linear")
        ).heights_m
        rise = heights[80] if metres is east_m else heights[:, 40]
        np.testing.assert_allclose(np.diff(rise), 10 / metres, rtol=1e-3)
        assert rise[len(rise) // 2] == pytest.approx(10.0, abs=1e-3)


def test_gaps_are_refused_or_filled(tmp_path: Path) -> None:
    holed = np.where(np.arange(GRID.size).reshape(GRID.shape) % 50 == 7, -9999, 260.0)
    file = write_asc(tmp_path / "a.asc", holed)
    with pytest.raises(ScenarioError, match=r"'a\.asc': 4 of the 180 cells that .* have no data \(fill_nodata"):
        build_terrain(raster(file))
    np.testing.assert_allclose(build_terrain(raster(file, fill_nodata=True)).heights_m, 10.0, atol=1e-4)
    nan = write_tif(tmp_path / "n.tif", np.where(holed < 0, np.nan, holed), "EPSG:32616")
    with pytest.raises(ScenarioError, match="4 of the 180 cells"):
        build_terrain(raster(nan))


@pytest.mark.parametrize(("interpolation", "half_width"), [("linear", 8), ("cubic", 20)])
def test_gaps_outside_the_terrain_do_not_matter(interpolation: str, half_width: int, tmp_path: Path) -> None:
    """A survey is a strip in a raster that is mostly empty."""
    rows, columns = np.mgrid[0:40, 0:60]
    sloped = 200.0 + 2.0 * rows + columns
    strip = np.where(abs(columns - 30) <= half_width, sloped, -9999)
    size = {"size_m": [150, 200], "interpolation": interpolation, "spacing_m": 5}
    built, whole = (
        build_terrain(raster(write_asc(tmp_path / "a.asc", grid), **size)).heights_m for grid in (strip, sloped)
    )
    np.testing.assert_allclose(built, whole, atol=1e-6)
    with pytest.raises(ScenarioError, match=r"'a\.asc': \d+ of the \d+ cells that the terrain needs have no data"):
        build_terrain(raster(write_asc(tmp_path / "a.asc", strip), **{**size, "size_m": [420, 200]}))


def test_a_file_of_several_bands_needs_a_choice(tmp_path: Path) -> None:
    file = write_tif(tmp_path / "b.tif", np.stack([GRID, GRID + 5, GRID]), "EPSG:32616")
    with pytest.raises(ScenarioError, match=r"'b\.tif': 3 bands, expected 1 \(choose one with band\)"):
        build_terrain(raster(file))
    with pytest.raises(ScenarioError, match="band = 4: the file has 3"):
        build_terrain(raster(file, band=4))
    np.testing.assert_allclose(build_terrain(raster(file, band=2)).heights_m, GRID[::-1] - 245, atol=1e-4)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.asc", b"hello", "not a readable elevation raster"),
        ("a.tif", b"II*\0junkjunk", "not a readable elevation raster"),
        ("a.asc", b"ncols 3\nnrows 3\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 5 6\n", "6 numbers for its 9"),
        ("a.asc", b"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 1\n1 2 3\n4 x 6\n", "line 7: 'x' is not a"),
        ("a.asc", b"ncols 3\nnrows 2\nxllcorner 0\nyllcorner 0\ncellsize 0\n1 2 3\n4 5 6\n", "a.asc"),
    ],
)
def test_malformed_rasters_are_refused_in_one_line(
    name: str, content: bytes, message: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / name).write_bytes(content)
    with pytest.raises(ScenarioError, match=message) as caught:
        build_terrain(raster(tmp_path / name))
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def write_degrees(path: Path, south: float) -> Path:
    return write_asc(path, GRID, 0.01, (-84.0, south))


@pytest.mark.parametrize(
    ("settings", "key", "message"),
    [
        ({"centre": [0, 0]}, "centre", r"terrain\.centre = \(0, 0\): outside 'a\.asc', which reaches from \(1000, 2"),
        ({"centre": [0, 0], "size_m": None}, "centre", r"terrain\.centre = \(0, 0\): outside"),
        ({"vertical_scale": 1e6}, "vertical_scale", r"terrain\.vertical_scale = 1e\+06: makes heights from -5e\+07 to"),
        ({"water_level_m": -12000}, "file", r"elevations from 200 to 297 make heights from 12200 .*water_level_m"),
        ({"crs": "EPSG:4326"}, "crs", r"terrain\.crs: 'a\.asc' is read as degrees, but .* of its middle is 2060"),
        ({"crs": "EPSG:4978"}, "crs", r"terrain\.crs: that of 'a\.asc' is neither geographic nor projected"),
    ],
)
def test_an_error_names_the_setting_at_fault(
    settings: dict[str, object], key: str, message: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        build_terrain(raster(write_asc(tmp_path / "a.asc", GRID), **settings))
    assert caught.value.at == (key,)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("size_m", [[140, 110], None])
def test_a_latitude_of_500_is_refused(size_m: object, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(ScenarioError, match=r"terrain\.centre = \(-83\.9, 500\): outside 'a\.asc'"):
        build_terrain(raster(write_degrees(tmp_path / "a.asc", 36.0), centre=[-83.9, 500], size_m=size_m))
    with pytest.raises(ScenarioError, match=r"latitude of its middle is 500\.06: must be between -90 and 90"):
        build_terrain(raster(write_degrees(tmp_path / "b.asc", 500.0), size_m=size_m))
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("kind", ["complex64", "complex_int16"])
def test_complex_numbers_are_refused_as_elevations(kind: str, tmp_path: Path) -> None:
    with rasterio.open(
        tmp_path / "c.tif", "w", driver="GTiff", count=1, height=12, width=15, dtype=kind,
        crs="EPSG:32616", transform=from_origin(500_000, 4_000_000, 10, 10),
    ):  # fmt: skip
        pass
    with pytest.raises(ScenarioError, match=r"'c\.tif': holds complex numbers, expected elevations"):
        build_terrain(raster(tmp_path / "c.tif"))


def test_a_raster_must_be_placed_and_large_enough(tmp_path: Path) -> None:
    Image.fromarray(GRID.astype(np.uint8)).save(tmp_path / "plain.tif")
    with pytest.raises(ScenarioError, match="has no position or size of its cells"):
        build_terrain(raster(tmp_path / "plain.tif"))
    with pytest.raises(ScenarioError, match="reaches beyond the raster: choose a smaller size_m"):
        build_terrain(raster(write_asc(tmp_path / "a.asc", GRID), size_m=[500, 100]))
    with pytest.raises(ScenarioError, match=r"terrain\.crs = 'EPSG:nine': not a coordinate system"):
        build_terrain(raster(tmp_path / "a.asc", crs="EPSG:nine"))


@pytest.mark.parametrize(("dtype", "white"), [(np.uint8, 255), (np.uint16, 65535)])
def test_heights_equal_an_image_at_its_pixels(dtype: type, white: int, tmp_path: Path) -> None:
    levels = RNG.integers(0, white + 1, (9, 11)).astype(dtype)
    levels[0, 0], levels[0, 1] = 0, white
    Image.fromarray(levels).save(tmp_path / "i.png")
    spec = ImageTerrain(source="image", file=tmp_path / "i.png", size_m=(100, 80), spacing_m=10, black_m=-30, white_m=5)
    heights = build_terrain(spec).heights_m
    np.testing.assert_allclose(heights, -30 + 35 * (levels[::-1] / white), atol=1e-4)
    assert heights[-1, 0] == -30
    assert heights[-1, 1] == 5


def test_images_that_are_not_grey_or_not_images_are_refused(tmp_path: Path) -> None:
    def build(name: str) -> Terrain:
        settings = {"source": "image", "size_m": [10, 10], "spacing_m": 1, "black_m": -9, "white_m": 0}
        return build_terrain(ImageTerrain.model_validate({**settings, "file": tmp_path / name}))

    colour = RNG.integers(0, 256, (8, 8, 3)).astype(np.uint8)
    Image.fromarray(colour).save(tmp_path / "colour.png")
    with pytest.raises(ScenarioError, match="a colour image, expected grey levels"):
        build("colour.png")
    Image.fromarray(np.repeat(colour[..., :1], 3, axis=2)).save(tmp_path / "grey.png")
    assert build("grey.png").lowest_m >= -9.5  # cubic interpolation may overshoot slightly
    whole = (tmp_path / "grey.png").read_bytes()
    (tmp_path / "half.png").write_bytes(whole[: len(whole) // 2])
    (tmp_path / "text.png").write_text("hello")
    for name in ("half.png", "text.png"):
        with pytest.raises(ScenarioError, match=f"{name}': not a readable image"):
            build(name)


def lake(**settings: object) -> NoiseTerrain:
    given = {"source": "noise", "size_m": [200, 150], "spacing_m": 2, "bed_depth_m": 30, "hill_height_m": 9}
    return NoiseTerrain.model_validate({**given, "hill_wavelength_m": 60, **settings})


def test_noise_repeats_for_one_seed_and_stays_within_its_hills() -> None:
    first, again, other = (build_terrain(lake(seed=seed)).heights_m for seed in (4, 4, 5))
    assert first.tobytes() == again.tobytes()
    assert (first != other).any()
    assert -39 <= first.min() < -32
    assert -28 < first.max() <= -21


def test_a_bed_too_deep_for_noise_is_a_chart_s() -> None:
    with pytest.raises(ValueError, match=r"in \[0, 1000\] m; a deeper bed is a chart's: source: raster") as caught:
        NoiseTerrain.model_validate({"source": "noise", "size_m": [40, 40], "bed_depth_m": 1800})
    with pytest.raises(ValueError, match=r"in \[0, 1000\] m \["):
        NoiseTerrain.model_validate({"source": "noise", "size_m": [40, 40], "bed_depth_m": -1})
    assert "1800" in str(caught.value)


def test_a_finer_noise_grid_has_the_same_heights() -> None:
    coarse, fine = build_terrain(lake()).heights_m, build_terrain(lake(spacing_m=1)).heights_m
    np.testing.assert_allclose(fine[::2, ::2], coarse, atol=1e-4)


@pytest.mark.parametrize("seed", range(5))
def test_the_rim_stands_out_of_the_water_on_all_sides(seed: int) -> None:
    z = build_terrain(lake(seed=seed, rim=Rim(height_m=8, width_m=40))).heights_m
    assert min(z[0].min(), z[-1].min(), z[:, 0].min(), z[:, -1].min()) >= 4.0 - 1e-4
    assert z[len(z) // 2, z.shape[1] // 2] < -20


def test_heights_between_nodes_are_those_of_the_triangles() -> None:
    terrain = Terrain(np.array([[0, 1, 0], [2, 5, 0]], np.float32), 2.0, (10.0, 20.0))
    corners = [[10, 20], [12, 20], [10, 22], [12, 22], [14, 22]]
    np.testing.assert_allclose(terrain.height_at(corners), [0, 1, 2, 5, 0])
    # The diagonal runs from the cell's lower right to its upper left corner: 1.5 at the centre, where bilinear gives 2.
    np.testing.assert_allclose(terrain.height_at([[11, 21], [10.5, 20.5], [11.5, 21.5]]), [1.5, 0.75, 3.25])
    assert np.isnan(terrain.height_at([[9.99, 20], [10, 22.01], [np.nan, 21]])).all()


def test_a_raster_that_names_a_server_does_not_reach_it(tmp_path):
    """GDAL virtual rasters read from any source named in their XML, so an untrusted scenario could contact a server."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        url = f"/vsicurl/http://127.0.0.1:{server.getsockname()[1]}/a.tif"
        file = tmp_path / "lake.tif"
        file.write_text(
            '<VRTDataset rasterXSize="3" rasterYSize="2"><GeoTransform>0,1,0,0,0,-1</GeoTransform>'
            '<VRTRasterBand dataType="Float32" band="1"><SimpleSource><SourceFilename relativeToVRT="0">'
            f"{url}</SourceFilename><SourceBand>1</SourceBand></SimpleSource></VRTRasterBand></VRTDataset>"
        )
        server.settimeout(0.0)
        with pytest.raises(ScenarioError, match=r"'lake\.tif': not a readable elevation raster"):
            build_terrain(raster(file))
        with pytest.raises(BlockingIOError):
            server.accept()


def test_a_text_grid_that_ends_within_a_number_is_said(tmp_path):
    file = write_asc(tmp_path / "a.asc", GRID)
    whole = file.read_bytes()
    build_terrain(raster(file))
    file.write_bytes(whole.rstrip()[:-1])
    with pytest.warns(UserWarning, match=r"'a\.asc': its last line, .* may be cut short"):
        build_terrain(raster(file))
