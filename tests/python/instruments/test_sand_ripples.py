"""Ripples of sand: sonars meet those that cameras see, if their direction is given; nothing else changes."""

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.validated import validated

FLAT = {
    "name": "flat",
    "terrain": {"source": "noise", "size_m": [60, 60], "bed_depth_m": 9, "hill_height_m": 0},
    "vehicles": [{"name": "rov", "model": "rov", "start": {"position_m": [0, 0, -5]}, "sonar": {"tilt_deg": 60}}],
}


def ping(mode: str, **ground: object) -> tuple[np.ndarray, np.ndarray]:
    """Return the ranges and the intensities of a ping."""
    with Simulator({**FLAT, "ground": ground}) as sim:
        sim.parameters["rov.sonar.mode"] = mode
        found = sim.rov.sonar.ping()
        return found.ranges_m, found.intensity_db


def test_they_change_the_levels_of_physics_mode_and_no_range_of_geometry_mode() -> None:
    flat, rippled = ping("physics"), ping("physics", ripples_deg=0)
    both = np.isfinite(flat[1]) & np.isfinite(rippled[1])
    assert both.mean() > 0.8 and np.median(np.abs(flat[1][both] - rippled[1][both])) > 0.1
    assert np.array_equal(ping("geometry")[0], ping("geometry", ripples_deg=0)[0])


def test_only_sand_has_them() -> None:
    with pytest.raises(ScenarioError, match="only a bed of sand has ripples"):
        validated(Scenario, {**FLAT, "ground": {"bed": "mud", "ripples_deg": 0}})
