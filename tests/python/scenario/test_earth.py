"""A world's location on Earth: the same for rasters, the key `earth` and every file and bridge."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from rasterio.crs import CRS
from rasterio.transform import from_origin

from uwsim import ScenarioError
from uwsim.mapping.files.georeference import Georeference, Home
from uwsim.scenario import Scenario, load
from uwsim.scenario.georeference import georeference
from uwsim.scenario.read.validated import validated

LATITUDE_DEG, LONGITUDE_DEG = 47.5, -122.3
EARTH = {"latitude_deg": LATITUDE_DEG, "longitude_deg": LONGITUDE_DEG}


def with_earth(**changes: Any) -> Scenario:
    return validated(Scenario, {**load("lagoon").given(), "earth": EARTH, **changes})


def test_metres_are_those_of_the_ellipsoid_and_degrees_lead_back() -> None:
    place = georeference(with_earth())
    near_m = np.array([80.0, -60.0, -5.0])
    assert Home(LATITUDE_DEG, LONGITUDE_DEG).world_m(*place.degrees(near_m), -5.0) == pytest.approx(near_m, abs=2e-3)
    far_m = np.array([9000.0, -7000.0, -5.0])
    assert place.world_m(*place.degrees(far_m), -5.0) == pytest.approx(far_m, abs=1e-4)
    assert place.degrees(np.zeros((2, 3))) == pytest.approx(np.array([[LATITUDE_DEG, LONGITUDE_DEG]] * 2), abs=1e-9)
    assert np.isinf(Georeference(CRS.from_epsg(32632)).world_m(0.0, 99.0, 0.0)[:2]).all()  # beyond what it can map


def test_the_grid_of_a_utm_zone_turns_by_its_convergence() -> None:
    """tan(c) = tan(longitude from the middle) sin(latitude) on a sphere; the ellipsoid adds less than 0.001 deg."""
    (x,), (y,) = rasterio.warp.transform("EPSG:4326", "EPSG:32632", [12.0], [50.0])
    utm = Georeference(CRS.from_epsg(32632), (x, y), 0.5)
    expected = math.atan(math.tan(math.radians(3.0)) * math.sin(math.radians(50.0)))
    assert utm.north_rad(np.zeros(3)) == pytest.approx(expected, abs=math.radians(2e-3))
    assert georeference(with_earth()).north_rad(np.zeros(3)) == pytest.approx(0.0, abs=1e-9)


def test_earth_is_refused_beside_a_raster_with_a_place_of_its_own(tmp_path: Path) -> None:
    file = tmp_path / "bed.tif"
    with rasterio.open(
        file, "w", driver="GTiff", width=9, height=9, count=1, dtype="float32", crs="EPSG:32632",
        transform=from_origin(500000, 5500000, 10, 10),
    ) as raster:  # fmt: skip
        raster.write(np.full((1, 9, 9), -20, np.float32))
    terrain = {"source": "raster", "file": str(file), "water_level_m": 0, "spacing_m": 10}
    with pytest.raises(ScenarioError, match=r"earth.*: must be left out, as the terrain's file has a place"):
        with_earth(terrain=terrain)
    local = georeference(with_earth(terrain={**terrain, "crs": "local"}))
    assert local.degrees(np.zeros(3)) == pytest.approx([LATITUDE_DEG, LONGITUDE_DEG])
    with pytest.raises(ScenarioError, match=r"latitude_deg = 91 deg: must be in \[-89, 89\]"):
        with_earth(earth={**EARTH, "latitude_deg": 91})
