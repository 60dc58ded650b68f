"""During a flight, the growing map is compared with the true surface."""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import uwsim
from uwsim import Simulator
from uwsim.flight.map_growth import FIRST_S, growth_row
from uwsim.mapping import OccupancyMap
from uwsim.missions import goto


def there(vehicle):
    vehicle.undock()
    yield from goto(vehicle, (0.0, 3.0), altitude_m=2.0)


def test_rows_are_of_the_map_as_it_was_then(tmp_path: Path) -> None:
    sim = Simulator("pool")
    flown = uwsim.fly(there, sim, tmp_path, map=True, voxel_m=0.5, time_limit_s=FIRST_S, report="json")
    assert flown.occupancy is not None
    (row,) = flown.map_growth
    assert row == growth_row(flown.occupancy, sim, FIRST_S), "the flight ends as the row is measured"
    assert json.loads((tmp_path / "summary.json").read_text())["map_growth"] == [row._asdict()]


def test_more_of_the_bed_is_in_the_map_later() -> None:
    flown = uwsim.fly(there, "pool", map=True, voxel_m=0.5, time_limit_s=12.0)
    assert len(flown.map_growth) > 2
    assert all(later.time_s > row.time_s for row, later in pairwise(flown.map_growth))
    assert flown.map_growth[-1].area_m2 > flown.map_growth[0].area_m2
    assert uwsim.fly(there, "pool", time_limit_s=6.0).map_growth == ()


def test_a_row_measures_distances_from_the_true_surface() -> None:
    sim, occupancy = Simulator("pool"), OccupancyMap(resolution_m=0.5)
    assert growth_row(occupancy, sim, 1.0) is None
    x, y = (part.ravel() for part in np.mgrid[-2:2:0.25, 4:8:0.25] + 0.1)
    above_m = 1.0 + sim.world.height_at(np.column_stack([x, y]))
    occupancy.insert_scan(np.column_stack([x, y, above_m]).astype(np.float32), (0.0, 6.0, -0.5))
    row = growth_row(occupancy, sim, 1.0)
    assert row is not None
    assert row.distance_mean_m == pytest.approx(1.0, abs=0.25), "half a voxel"
    assert row.area_m2 == pytest.approx(16.0, rel=0.3)
