"""uwsim twin: a chart, an area and a log become a scenario that loads and a report that names what is unknown."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from command_line import error_line
from command_line import uwsim as command
from flight_logs import VEHICLE, flown, telemetry
from uwsim.scenario import load

pytest.importorskip("pymavlink", reason="needs the extra mavlink")
rasterio = pytest.importorskip("rasterio")
EAST_M, NORTH_M = 500_000.0, 5_000_000.0


def chart(folder: Path) -> Path:
    """200 x 200 m at 2 m, 20 m deep in the west and 30 m in the east, in UTM 32 N."""
    heights = np.tile(np.linspace(-20.0, -30.0, 100, dtype=np.float32), (100, 1))
    place = rasterio.Affine(2.0, 0.0, EAST_M - 100, 0.0, -2.0, NORTH_M + 100)
    with rasterio.open(
        folder / "tile.tif",
        "w",
        driver="GTiff",
        height=100,
        width=100,
        count=1,
        dtype="float32",
        crs="EPSG:32632",
        transform=place,
    ) as file:
        file.write(heights, 1)
    return folder / "tile.tif"


def area(folder: Path, half_m: float = 40.0) -> Path:
    from rasterio.warp import transform

    corners = [(-half_m, -half_m), (half_m, -half_m), (half_m, half_m), (-half_m, half_m), (-half_m, -half_m)]
    x, y = zip(*((EAST_M + e, NORTH_M + n) for e, n in corners), strict=True)
    ring = [list(corner) for corner in zip(*transform("EPSG:32632", "EPSG:4326", x, y), strict=True)]
    shape = {"type": "Feature", "properties": {}, "geometry": {"type": "Polygon", "coordinates": [ring]}}
    (folder / "site.geojson").write_text(json.dumps({"type": "FeatureCollection", "features": [shape]}))
    return folder / "site.geojson"


def test_a_dive_becomes_a_scenario_and_a_report(tmp_path: Path) -> None:
    (tmp_path / "dive.tlog").write_bytes(telemetry(flown()))
    words = ["twin", "--area", area(tmp_path), "--chart", chart(tmp_path), "--log", tmp_path / "dive.tlog"]
    done = command(*words, "--vehicle", VEHICLE, "--out", tmp_path / "twin")
    assert done.returncode == 0, done.stderr
    scenario = load(tmp_path / "twin" / "site.yaml")
    assert scenario.vehicles[0].model.name == VEHICLE
    assert scenario.survey is not None
    np.testing.assert_allclose(np.abs(scenario.survey.area_m), 40.0, atol=2.5)
    report = (tmp_path / "twin" / "report.md").read_text()
    for line in (
        "## Measured",
        "the bed from tile.tif",
        "the current, of which neither chart nor log states anything",
        "the bed that the vehicle saw",
        "| horizon [s] |",
    ):
        assert line in report, report


def test_the_bed_along_the_track_is_compared_with_the_chart(tmp_path: Path) -> None:
    from rasterio.warp import transform

    def bed(position) -> tuple[float, float, float]:
        (lon,), (lat,) = transform("EPSG:32632", "EPSG:4326", [EAST_M + position[0]], [NORTH_M + position[1]])
        return lat, lon, 20.0 + 10.0 * (position[0] + 99.0) / 198.0 + 0.5  # half a metre below the chart

    (tmp_path / "dive.tlog").write_bytes(telemetry(flown(), bed=bed))
    words = ["twin", "--area", area(tmp_path), "--chart", chart(tmp_path), "--log", tmp_path / "dive.tlog"]
    done = command(*words, "--vehicle", VEHICLE, "--out", tmp_path / "twin")
    assert done.returncode == 0, done.stderr
    rows = list(csv.DictReader((tmp_path / "twin" / "bed.csv").open()))
    differences = np.array([float(row["measured_m"]) - float(row["charted_m"]) for row in rows])
    assert len(rows) > 200  # those of an upright vehicle
    assert float(np.median(differences)) == pytest.approx(0.5, abs=0.05)
    assert np.ptp(differences) < 0.2
    report = (tmp_path / "twin" / "report.md").read_text()
    assert f"the bed along the track, from {len(rows)} ranges (bed.csv): deeper than the chart by 0.5" in report


def test_an_area_that_is_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "dive.tlog").write_bytes(telemetry(flown()))
    (tmp_path / "site.geojson").write_text('{"type": "Point", "coordinates": [1, 2]}')
    words = ["--chart", chart(tmp_path), "--log", tmp_path / "dive.tlog", "--out", tmp_path / "twin"]
    done = command("twin", "--area", tmp_path / "site.geojson", *words)
    assert "site.geojson: has no area: must have a polygon" in error_line(done)
    done = command("twin", "--area", area(tmp_path, 1.0), *words)
    assert "m wide: must be 5 to 20000 m" in error_line(done)
