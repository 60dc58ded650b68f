"""Intervals that packaged vehicles' files state for their kind."""

import re

import numpy as np
import pytest
from scipy.stats import t as student

from uwsim.scenario import load_vehicle
from uwsim.scenario.read.assets import assets_folder


def test_the_interval_of_slocums_drag_is_that_of_all_whose_flights_are_known() -> None:
    """The next of a kind of which n are known, by Student's t: the two of 2014, and those of 2008 and 2021."""
    fitted = load_vehicle("slocum").quadratic_damping[0]
    drags = np.log(fitted / np.array([1.0, 1.0, 1.46, 1.53]))
    reach = student.ppf(0.975, len(drags) - 1) * drags.std(ddof=1) * np.sqrt(1.0 + 1.0 / len(drags))
    text = (assets_folder() / "vehicles/slocum.yaml").read_text()
    found = re.search(r"{low: ([0-9.]+), high: ([0-9.]+), scale: lognormal}", text)
    assert found is not None
    ends = np.exp([drags.mean() - reach, drags.mean() + reach])
    assert [float(end) for end in found.groups()] == pytest.approx(ends, rel=0.01)
