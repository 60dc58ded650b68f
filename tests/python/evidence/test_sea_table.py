"""`uwsim vehicle hull.stl --draft --sea`: a floating hull's radiation table from its mesh."""

from pathlib import Path

import numpy as np
import pytest

from uwsim.base.whole_trimesh import trimesh
from uwsim.evidence.validate.peers.floating_hulls import floating_hull
from uwsim.evidence.vehicle import sea_table
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.radiation_file import read_radiation

HEAVE, ROLL, PITCH = 2, 3, 4


def written(folder: Path, mass_kg: float) -> str:
    box = trimesh.creation.box((2.0, 0.8, 0.6))
    return sea_table.write_sea_table(folder / "sea.nc", np.asarray(box.vertices), box.faces, mass_kg, 0.0, 1000.0)


def test_a_hull_that_sinks_is_refused_and_nothing_is_written(tmp_path):
    with pytest.raises(ScenarioError, match="--sea needs a hull that floats"):
        written(tmp_path, 960.0)
    assert not list(tmp_path.iterdir())


def test_panels_cover_the_hull_under_water():
    box = trimesh.creation.box((2.0, 0.8, 0.6))
    for count in (sea_table.COARSE_PANELS, sea_table.FINE_PANELS):
        points, faces = sea_table._panels(np.asarray(box.vertices), box.faces, count)
        wet = trimesh.Trimesh(points, faces, process=False)
        assert points[:, 2].max() <= 1e-9
        assert wet.area == pytest.approx(2.0 * 0.8 + 2.0 * 0.3 * (2.0 + 0.8))
        assert 0.4 * count < len(faces) < 1.4 * count


def test_a_box_has_the_waves_of_the_stored_barge(tmp_path, monkeypatch):
    pytest.importorskip("capytaine", reason="Capytaine computes the table")
    monkeypatch.setattr(sea_table, "FINE_PANELS", 200)
    monkeypatch.setattr(sea_table, "COARSE_PANELS", 100)
    monkeypatch.setattr(sea_table, "FREQUENCIES", 8)
    assert "% of the largest" in written(tmp_path, 480.0)
    got, stored = read_radiation(tmp_path / "sea.nc"), floating_hull("barge").table
    for axis in (HEAVE, ROLL, PITCH):
        for quantity in ("added_mass", "damping"):
            ours, theirs = getattr(got, quantity)[:, axis, axis], getattr(stored, quantity)[:, axis, axis]
            inside = (got.omega_rad_s > 1.0) & (got.omega_rad_s < 6.0)  # of waves that 200 panels resolve
            expected = np.interp(got.omega_rad_s[inside], stored.omega_rad_s, theirs)
            np.testing.assert_allclose(ours[inside], expected, atol=0.1 * np.abs(theirs).max())
