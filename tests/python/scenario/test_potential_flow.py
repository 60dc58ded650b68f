"""The added mass of a mesh on which panels fail is that of the same shape by the next remedy."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.scenario.build import hydrodynamics
from uwsim.scenario.build.hydrodynamics import added_mass_by_steps, added_mass_of_ellipsoid, added_mass_of_mesh
from uwsim.scenario.read.errors import ScenarioError


@pytest.fixture(autouse=True)
def few_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(hydrodynamics, "PANELS", 600)


def cubes(gap_m: float) -> tuple[Floats, NDArray[np.int64]]:
    pair = [trimesh.creation.box(bounds=[(x, 0, 0), (x + 1, 1, 1)]) for x in (0.0, 1.0 + gap_m)]
    both = trimesh.util.concatenate(pair)
    return np.array(both.vertices), np.array(both.faces)


def test_cubes_that_touch_move_as_much_water_as_one_box() -> None:
    """The panels of the common face lie on each other: the core returns an added mass of 1e17 kg."""
    with pytest.raises(ScenarioError, match="panels on 24 triangles have an impossible result"):
        added_mass_of_mesh(*cubes(0.0), 1000.0)
    found, remedy = added_mass_by_steps(*cubes(0.0), 1000.0)
    assert remedy == "panels fail on its mesh, which is shifted by 1e-05 of its size"
    box = trimesh.creation.box(bounds=[(0, 0, 0), (2, 1, 1)])
    one = added_mass_of_mesh(np.array(box.vertices), np.array(box.faces), 1000.0)
    np.testing.assert_allclose(np.diagonal(found), np.diagonal(one), rtol=0.05, atol=5.0)
    assert added_mass_by_steps(*cubes(1.0), 1000.0)[1] == ""


def test_where_all_panels_fail_the_ellipsoid_of_the_same_volume_and_ratios_is_left(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    tried: list[int] = []

    def fails(_points: object, faces: Floats, *_: object) -> Floats:
        tried.append(len(faces))
        raise ValueError("mesh.triangles = 1: must be no slivers")

    monkeypatch.setattr(hydrodynamics._core, "added_mass", fails)
    axes_m, at_m = np.array([1.0, 0.3, 0.2]), np.array([0.5, 0.0, -0.1])
    ball = trimesh.creation.icosphere(4)
    found, remedy = added_mass_by_steps(np.array(ball.vertices) * axes_m + at_m, np.array(ball.faces), 1000.0)
    assert remedy == "panels fail on its mesh, which is replaced by Lamb's ellipsoid of its volume" and len(tried) == 6
    lamb = added_mass_of_ellipsoid(axes_m, 1000.0)
    np.testing.assert_allclose(np.diagonal(found)[:3], lamb[:3], rtol=0.01)
    assert found[4, 4] == pytest.approx(lamb[4] + lamb[2] * at_m[0] ** 2 + lamb[0] * at_m[2] ** 2, rel=0.01)
    assert found[2, 4] == pytest.approx(-lamb[2] * at_m[0], rel=0.01)
