"""A chart's numbers become metres on Earth, by whatever projection and unit, or they are asked for."""

from pathlib import Path

import numpy as np
import pytest
import rasterio
from affine import Affine
from pyproj import Geod, Transformer

from uwsim.exchange.charts import scenario_from_chart
from uwsim.exchange.cli.scenario_from import scenario_from
from uwsim.scenario import ScenarioError, build_world, load
from uwsim.scenario.georeference import georeference

N = 120
EAST, SOUTH = np.meshgrid(np.arange(N), np.arange(N))
BED = (-20.0 - 0.05 * EAST + 0.03 * SOUTH).astype(np.float32)


def chart(path: Path, heights=BED, crs="EPSG:32610", at=(500_000.0, 4_000_000.0), cell=2.0, unit=None, **more) -> Path:
    """Write a GeoTIFF of square cells whose north-west corner is at a place."""
    with rasterio.open(path, "w", driver="GTiff", width=N, height=N, count=1, dtype=heights.dtype, crs=crs,
                       **{"transform": Affine(cell, 0, at[0], 0, -cell, at[1])} | more) as file:  # fmt: skip
        file.write(heights, 1)
        if unit is not None:
            file.units = (unit,)
    return path


def middle_m(path: Path, **options) -> float:
    """Return the height of the bed in the middle of the scenario that a chart becomes."""
    made = scenario_from_chart(path, path.with_suffix(".yaml"), size_m=100.0, **options)
    return float(build_world(load(made.path)).height_at(np.zeros((1, 2)))[0])


PLACES = {
    "EPSG:32610": (-122.9, 36.1),
    "EPSG:32631": (0.01, 0.01),  # UTM at the edge of its zone: 0.098 % long
    "EPSG:3857": (-122.0, 36.7),  # Web Mercator: 25 % long here
    "EPSG:3395": (20.0, 60.0),  # Mercator on the ellipsoid: twice as long
    "EPSG:6933": (5.0, 60.0),  # cylindrical and of equal area: long to the east, short to the north
    "EPSG:3035": (-30.0, 60.0),  # azimuthal and of equal area, 40 degrees from its middle: turned, too
    "EPSG:2226": (-122.0, 38.5),  # conic and conformal, in feet
    "EPSG:3995": (25.0, 78.0),  # polar stereographic, north
    "EPSG:3031": (-60.0, -65.0),  # polar stereographic, south
    "EPSG:2154": (3.0, 42.5),  # conic and conformal, outside its parallels: 0.15 % long
    "EPSG:5070": (-80.0, 32.0),  # conic and of equal area (Albers)
    "EPSG:27700": (-5.0, 50.0),  # transverse Mercator, on Airy's ellipsoid
    "EPSG:2056": (8.5, 47.4),  # oblique Mercator: Switzerland's
    "EPSG:28992": (4.0, 52.0),  # oblique stereographic: RD New
    "EPSG:4326": (5.0, 43.0),
}


@pytest.mark.parametrize("turned_deg", [0.0, 30.0])
@pytest.mark.parametrize("crs", PLACES)
def test_200_m_of_the_world_are_200_m_on_the_ellipsoid_and_the_bed_is_the_chart_s_there(
    crs: str, turned_deg: float, tmp_path: Path
) -> None:
    of_degrees = Transformer.from_crs("EPSG:4326", crs, always_xy=True)
    x, y = of_degrees.transform(*PLACES[crs])
    cell = {"EPSG:2226": 20.0, "EPSG:4326": 1e-4}.get(crs, 8.0)
    pixels = Affine.translation(x, y) * Affine.rotation(turned_deg) * Affine.scale(cell, -cell)
    pixels *= Affine.translation(-N / 2, -N / 2)
    path = chart(tmp_path / "a.tif", crs=crs, transform=pixels, unit="m")
    scenario = load(scenario_from_chart(path, tmp_path / "a.yaml", size_m=250.0).path)
    world = georeference(scenario)
    np.testing.assert_allclose(world.degrees(np.zeros(2)), PLACES[crs][::-1], rtol=0, atol=1e-6)
    places = np.array([[-100.0, 0.0], [100.0, 0.0], [0.0, -100.0], [0.0, 100.0]])
    latitude, longitude = world.degrees(places).T
    _, _, far_m = Geod(ellps="WGS84").inv(longitude[::2], latitude[::2], longitude[1::2], latitude[1::2])
    np.testing.assert_allclose(far_m, 200.0, rtol=1e-3)
    column, row = ~pixels * np.array(of_degrees.transform(longitude, latitude))
    found = build_world(scenario).height_at(places)
    np.testing.assert_allclose(found, -20.0 - 0.05 * (column - 0.5) + 0.03 * (row - 0.5), atol=2e-3)


NAMES = ["A B.TIF", "Meeresböden ü.tif", "a.b.c.tiff", "..tif", "-x.tif", "'q\" #.Tif", "数.tif"]


@pytest.mark.parametrize("name", NAMES)
def test_a_chart_may_have_any_name(name: str, tmp_path: Path) -> None:
    made = scenario_from_chart(chart(tmp_path / name), tmp_path / "own.yaml", size_m=100.0)
    assert build_world(load(made.path)).height_at(np.zeros((1, 2)))[0] == pytest.approx(-21.2, abs=0.1)


@pytest.mark.parametrize("unit, metres", [("US survey foot", 1200 / 3937), ("ft", 0.3048), ("fathoms", 1.8288),
                                          ("cm", 0.01), ("metres above MSL", 1.0), (None, 1.0)])  # fmt: skip
def test_heights_are_metres_by_the_unit_of_their_band(unit: str | None, metres: float, tmp_path: Path) -> None:
    deep = (BED / metres).astype(np.float32)
    assert middle_m(chart(tmp_path / "a.tif", deep, unit=unit)) == pytest.approx(-21.2, abs=0.1)


def test_heights_are_metres_by_the_unit_of_their_vertical_reference(tmp_path: Path) -> None:
    deep = (BED * 3937 / 1200).astype(np.float32)
    assert middle_m(chart(tmp_path / "a.tif", deep, crs="EPSG:32610+6360")) == pytest.approx(-21.2, abs=0.1)


def test_packed_heights_are_unpacked(tmp_path: Path) -> None:
    path = chart(tmp_path / "a.tif", np.round(-100.0 * BED).astype(np.int16))
    with rasterio.open(path, "r+") as file:
        file.scales, file.offsets = (-0.01,), (-5.0,)
    assert middle_m(path) == pytest.approx(-26.2, abs=0.1)


def test_a_unit_that_the_file_leaves_open_is_asked_for(tmp_path: Path) -> None:
    feet = chart(tmp_path / "feet.tif", crs="EPSG:2226", at=(6e6, 2e6), cell=6.0)
    with pytest.raises(ScenarioError, match=r"US survey foot.*does not state the unit of its heights.*--unit"):
        middle_m(feet)
    assert middle_m(feet, unit="us-ft") == pytest.approx(-21.2 * 1200 / 3937, abs=0.1)
    with pytest.raises(ScenarioError, match=r"heights are in 'smoots': give their unit as unit, m, ft, us-ft"):
        middle_m(chart(tmp_path / "odd.tif", unit="smoots"))


@pytest.mark.parametrize("gap", [-9999.0, 9999.0, -99999.0, -32768.0, -999.0])
def test_a_gap_that_is_not_declared_is_a_question_and_not_a_bed(gap: float, tmp_path: Path) -> None:
    heights = BED.copy()
    heights[:20] = gap
    path = chart(tmp_path / "a.tif", heights)
    rule = rf"2400 of 14400 cells are {gap:.0f}, .*give nodata: {gap:.0f} .*--nodata {gap:.0f}"
    with pytest.raises(ScenarioError, match=rule):
        scenario_from(path, out=tmp_path / "a.yaml")
    assert not (tmp_path / "a.yaml").exists()
    scenario_from(path, out=tmp_path / "a.yaml", nodata=gap)
    scenario = load(tmp_path / "a.yaml")
    assert scenario.terrain.nodata == gap
    assert build_world(scenario).height_at(np.zeros((1, 2)))[0] == pytest.approx(-20.0, abs=5.0)


def test_a_trench_of_9999_m_is_a_bed(tmp_path: Path) -> None:
    slope = np.linspace(-9000.0, -9999.0, N * N, dtype=np.float32).reshape(N, N)
    assert middle_m(chart(tmp_path / "a.tif", slope)) == pytest.approx(-9499.0, abs=10.0)


def test_any_file_s_name_becomes_a_name_and_depths_that_are_positive_are_explained(tmp_path: Path) -> None:
    for stem in ("2019_survey", "gebco_2024_n44.0_s43.0_w5.0_e6.0_and_more"):
        made = scenario_from_chart(chart(tmp_path / f"{stem}.tif"), tmp_path / f"{stem}.yaml", size_m=100.0)
        assert load(made.path).name[0].isalpha()
    with pytest.raises(ValueError, match=r"its heights are all positive: if they are depths, give --positive down"):
        middle_m(chart(tmp_path / "down.tif", -BED))
    assert middle_m(chart(tmp_path / "down.tif", -BED), positive="down") == middle_m(chart(tmp_path / "up.tif"))


@pytest.mark.parametrize(("cell", "size_m"), [(0.1, 200.0), (1 / 240, 5000.0)])
def test_a_world_of_large_cells_is_a_part_of_their_slope(cell: float, size_m: float, tmp_path: Path) -> None:
    path = chart(tmp_path / "world.tif", crs="EPSG:4326", at=(4.0, 3.0), cell=cell, unit="m")
    made = scenario_from_chart(path, tmp_path / "world.yaml", size_m=size_m)
    assert made.size_m == size_m
    assert build_world(load(made.path)).height_at(np.zeros((1, 2)))[0] == pytest.approx(-21.2, abs=0.1)
