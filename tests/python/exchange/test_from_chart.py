"""`uwsim scenario from` a chart: the largest square without gaps becomes a bed at its place, with its own heights."""

import io
from pathlib import Path

import h5py
import numpy as np
import pytest
import rasterio
from affine import Affine
from rasterio.shutil import copy

from uwsim.exchange.charts import _largest_squares, scenario_from_chart
from uwsim.exchange.cli.scenario_from import scenario_from
from uwsim.exchange.scenario_source import source_of
from uwsim.scenario import build_world, load
from uwsim.scenario.georeference import georeference

REAL = Path(__file__).parents[4] / "shared" / "reality" / "bathymetry"


def write(path: Path, heights: np.ndarray, driver: str, crs: str, transform: Affine) -> Path:
    rows, columns = heights.shape
    tiff = path.with_suffix(".tif")
    with rasterio.open(tiff, "w", driver="GTiff", width=columns, height=rows, count=1, dtype="float32", nodata=-9999.0,
                       crs=crs, transform=transform) as file:  # fmt: skip
        file.write(np.where(np.isfinite(heights), heights, -9999.0).astype(np.float32), 1)
    if driver != "GTiff":
        copy(tiff, path, driver=driver)
    return path


def s102(depths: np.ndarray, west_m: float, south_m: float, spacing_m: float) -> bytes:
    """Return what matters of S-102 3.0.0 (IHO, 2024): depths in rows from the south, positive down, in UTM zone 10."""
    rows, columns = depths.shape
    values = np.zeros((rows, columns), [("depth", "<f4")])
    values["depth"] = np.where(np.isfinite(depths), depths, 1e6)
    with h5py.File(memory := io.BytesIO(), "w") as file:
        file.attrs["productSpecification"] = "INT.IHO.S-102.3.0.0"
        file.attrs["horizontalCRS"] = np.int32(32610)
        file.create_group("Group_F")
        coverage = file.create_group("BathymetryCoverage").create_group("BathymetryCoverage.01")
        for axis, origin, count in (("Longitud", west_m, columns), ("Latitud", south_m, rows)):
            coverage.attrs[f"gridOrigin{axis}e"] = origin + 0.5 * spacing_m
            coverage.attrs[f"gridSpacing{axis}inal"] = spacing_m
            coverage.attrs[f"numPoints{axis}inal"] = np.uint32(count)
        coverage.attrs["startSequence"] = "0,0"
        coverage.create_group("Group_001").create_dataset("values", data=values)
    return memory.getvalue()


def test_the_largest_square_is_that_of_trying_all():
    known = np.random.default_rng(1).random((14, 19)) > 0.2
    edges = _largest_squares(known)
    for row, column in np.ndindex(known.shape):
        tried = max((side for side in range(1, min(row, column) + 2)
                     if known[row - side + 1 : row + 1, column - side + 1 : column + 1].all()), default=0)  # fmt: skip
        assert edges[row, column] == tried


def test_a_chart_with_gaps_becomes_the_bed_of_its_largest_square(tmp_path):
    east, south = np.meshgrid(np.arange(80), np.arange(60))
    heights = -30.0 + 0.1 * east - 0.05 * south
    heights[:8], heights[:, 50:] = np.nan, np.nan
    chart = write(tmp_path / "inlet.tif", heights, "GTiff", "EPSG:32610", Affine(4, 0, 520_000, 0, -4, 5_330_000))
    made = scenario_from_chart(chart, tmp_path / "inlet.yaml", size_m=1000.0)
    scenario = load(tmp_path / "inlet.yaml")
    assert made.size_m == pytest.approx(196.0)  # 50 cells, between the middles of the outermost
    assert scenario.terrain.file == chart.resolve()
    places = np.array([[0.0, 0.0], [40.0, -20.0], [-60.0, 70.0]])
    found = build_world(scenario).height_at(places)
    middle = -30.0 + 0.1 * (50 / 2 - 0.5) - 0.05 * (float(made_row(scenario)) - 0.5)
    np.testing.assert_allclose(found, middle + 0.1 * places[:, 0] / 4 + 0.05 * places[:, 1] / 4, atol=2e-3)
    assert georeference(scenario).degrees([0, 0, 0]) == pytest.approx([48.11, -122.73], abs=0.05)


def made_row(scenario) -> float:
    return (5_330_000 - scenario.terrain.centre[1]) / 4


def test_an_s_102_is_the_bed_of_the_same_geotiff(tmp_path):
    """S-102 has depths from the south, GeoTIFF elevations from the north."""
    east, north = np.meshgrid(np.arange(60), np.arange(50))
    depths = 20.0 + 0.1 * east + 0.15 * north + 2.0 * np.sin(0.2 * north)
    depths[:5, :9] = np.nan
    (chart := tmp_path / "chart.h5").write_bytes(s102(depths, 520_000.0, 5_330_000.0, 4.0))
    tiff = write(tmp_path / "chart.tif", -depths[::-1], "GTiff", "EPSG:32610", Affine(4, 0, 520_000, 0, -4, 5_330_200))
    assert source_of(chart).what.startswith("a chart")
    beds = []
    for source in (chart, tiff):
        made = scenario_from_chart(
            source, tmp_path / f"{source.suffix[1:]}.yaml", size_m=100.0, centre=(520_140, 5_330_100)
        )
        scenario = load(made.path)
        beds.append(
            (made.depth_m, build_world(scenario).height_at(np.array([[0.0, 0.0], [30.0, -20.0], [-40.0, 45.0]])))
        )
    assert beds[0][0] == pytest.approx(beds[1][0], abs=1e-4)
    np.testing.assert_allclose(beds[0][1], beds[1][1], atol=1e-4)
    assert beds[0][1][0] == pytest.approx(-(20.0 + 3.5 + 3.75 + 2.0 * np.sin(5.0)), abs=0.3)


def test_degrees_are_a_place_too(tmp_path):
    heights = np.full((40, 60), -55.0)
    chart = write(tmp_path / "gebco.nc", heights, "netCDF", "EPSG:4326", Affine(1 / 240, 0, 5, 0, -1 / 240, 43))
    made = scenario_from_chart(chart, tmp_path / "sea.yaml", size_m=800.0, centre=(5.1, 42.95))
    scenario = load(tmp_path / "sea.yaml")
    assert made.depth_m == (55.0, 55.0)
    assert georeference(scenario).degrees([0, 0, 0]) == pytest.approx([42.95, 5.1], abs=1e-6)


@pytest.mark.parametrize(
    "crs, step, said",
    [("EPSG:32610", 4.0, ""), (None, 4.0, "in plain metres"), (None, 1 / 240, "degrees of EPSG:4326")],
)
def test_a_chart_that_names_no_coordinate_system_says_what_it_is_taken_for(crs, step, said, tmp_path):
    transform = Affine(step, 0, 5, 0, -step, 43)
    chart = write(tmp_path / "a.tif", np.full((40, 60), -55.0), "GTiff", crs, transform)
    notes = scenario_from_chart(chart, tmp_path / "sea.yaml", size_m=100.0).notes
    assert len(notes) == bool(said) and all(said in note.text and "--crs" in note.text for note in notes)


def test_land_and_other_files_are_refused_and_nothing_is_written(tmp_path):
    land = write(tmp_path / "land.tif", np.full((9, 9), 3.0), "GTiff", "EPSG:32610", Affine(4, 0, 5e5, 0, -4, 5e6))
    (tmp_path / "text.bag").write_text("not a chart")
    for source, rule in ((land, "must lie 1 m below it"), (tmp_path / "text.bag", "not a readable elevation raster")):
        with pytest.raises(ValueError, match=rule):
            scenario_from_chart(source, tmp_path / "out.yaml", size_m=100.0)
    with pytest.raises(ValueError, match="--scene: is not for a chart"):
        scenario_from(land, scene="LawnTest")
    assert not (tmp_path / "out.yaml").exists()
    (tmp_path / "mine.yaml").write_text("mine")
    with pytest.raises(FileExistsError):
        scenario_from_chart(land, tmp_path / "mine.yaml", size_m=100.0)


def test_a_real_bag_becomes_a_scenario(tmp_path):
    chart = REAL / "F00788_SR_8m.bag"
    if not chart.exists():
        pytest.skip("the real chart is not here: it is not ours to keep")
    made = scenario_from_chart(chart, tmp_path / "sound.yaml", size_m=500.0)
    assert made.size_m == pytest.approx(392.0)  # 50 x 50 nodes at 8 m, between their middles
    with rasterio.open(chart) as file:
        elevations = file.read(1)
        scenario = load(tmp_path / "sound.yaml")
        x, y = np.meshgrid(np.arange(-20, 21) * 8.0, np.arange(-20, 21) * 8.0)
        places = np.column_stack([x.ravel(), y.ravel()]) + 4.0 * (made.size_m % 16 == 8)
        rows, columns = rasterio.transform.rowcol(file.transform, *(places + scenario.terrain.centre).T)
        found = build_world(scenario).height_at(places)
        near = np.array([elevations[r - 1 : r + 2, c - 1 : c + 2].ravel() for r, c in zip(rows, columns, strict=True)])
    assert ((found >= near.min(axis=1) - 1e-3) & (found <= near.max(axis=1) + 1e-3)).all()
