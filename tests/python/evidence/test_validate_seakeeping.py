"""The tables of floating hulls are what Capytaine computes; tools/docs checks that the hulls move by them."""

import runpy
from pathlib import Path

import numpy as np
import pytest

from uwsim.evidence.validate.peers import floating_hulls
from uwsim.evidence.validate.peers.floating_hulls import floating_hull
from uwsim.scenario.read.radiation_file import read_radiation

HEMISPHERE = {0.2: (0.808, 0.281), 0.5: (0.598, 0.339), 0.8: (0.482, 0.288), 1.0: (0.441, 0.246), 1.3: (0.409, 0.189)}
"""By ka: added mass over that displaced, damping over that and the frequency, of finer panels (Capytaine 3.0.0)."""


def test_short_waves_push_as_on_a_wall_and_long_ones_not_at_all() -> None:
    """rho g a^2 / 2 per width (Maruo 1960): a wall reflects all; a ball's sides, by their slope, two thirds of it."""
    for name, width_m, share in (("barge", 0.8, 1.0), ("hemisphere", 1.0, 2.0 / 3.0)):
        drift = floating_hull(name).table.drift[:, 0, 0]
        assert drift[-1] == pytest.approx(share * 0.5 * 9810.0 * width_m, rel=0.06)
        assert np.abs(drift[:8]).max() < 0.01


def test_the_tables_are_those_of_finer_panels_within_a_few_per_cent() -> None:
    table = read_radiation(floating_hulls.table_file("hemisphere"))
    radius = (1.5 * table.displaced_kg / (1000.0 * np.pi)) ** (1.0 / 3.0)
    for ka, (added, damping) in HEMISPHERE.items():
        omega = np.sqrt(9.81 * ka / radius)
        found = [
            np.interp(omega, table.omega_rad_s, each[:, 2, 2]) / table.displaced_kg
            for each in (table.added_mass, table.damping)
        ]
        np.testing.assert_allclose([found[0], found[1] / omega], [added, damping], rtol=0.025)


def test_capytaine_recomputes_its_tables() -> None:
    pytest.importorskip("capytaine", reason="pip install capytaine")
    make = runpy.run_path(str(Path(__file__).parents[1] / "data/make_capytaine_seakeeping.py"))
    kept = read_radiation(floating_hulls.table_file("barge"))
    row = 12
    found = make["dataset"](make["barge"](), 0.0, [float(kept.omega_rad_s[row]), np.inf])
    np.testing.assert_allclose(found["added_mass"].values[0], kept.added_mass[row], rtol=1e-3, atol=0.05)
    np.testing.assert_allclose(found["radiation_damping"].values[0], kept.damping[row], rtol=1e-3, atol=0.05)
