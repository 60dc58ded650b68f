"""Surfaces as they are seen: facets of round bodies are smooth, edges stay edges, and sand has its ripples."""

import numpy as np
import pytest
import trimesh
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from uwsim import Simulator, _core
from uwsim.evidence.validate.pictures import Light
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.read.validated import validated

EYE_M, AT_M = (0.0, 0.0, -4.0), (3.0, 0.0, -5.0)
LEVEL = (0.0, 0.0, 0.0, 1.0)
DOWN = Rotation.from_euler("Y", np.arctan2(1, 3)).as_quat()


def seen(mesh: trimesh.Trimesh, *effects: str, turn: Rotation | None = None) -> _core.Picture:
    """Return a picture of a solid, or of a vehicle with this attitude whose mesh is turned back by it."""
    world = _core.World()
    if turn is None:
        label = world.add_solid("body", mesh.vertices + AT_M, mesh.faces)
    scene = _core.CameraScene(world, _core.RayScene(world), 0)
    if turn is None:
        scene.set_appearance(label, "plain", "structure")
        placed = {}
    else:
        scene.add_vehicle("body", turn.inv().apply(mesh.vertices), mesh.faces, "plain")
        placed = {"vehicle_positions_m": [AT_M], "vehicle_orientations_xyzw": [turn.as_quat()]}
    camera = _core.Camera("check", _core.Lens(97, 97, 120.0, 120.0, 48.0, 48.0))
    return scene.render(camera, Light("I").optics, EYE_M, DOWN, 0.0, 0, effects, keep_radiance=True, **placed)


def green(picture: _core.Picture) -> NDArray[np.float64]:
    return np.asarray(picture.radiance, np.float64)[..., 1]


@pytest.mark.parametrize("effects", [("sunlight",), ("sunlight", "shadows")])
def test_a_ball_of_triangles_is_lit_as_the_sphere(effects: tuple[str, ...]) -> None:
    exact, found = (green(seen(trimesh.creation.icosphere(k, 1.0), *effects)) for k in (6, 2))
    both = (exact > 0) & (found > 0)
    error = np.abs(found - exact)[both] / exact.max()
    assert np.quantile(error, 0.98) < 0.03  # 0.11 with facets


def test_a_vehicle_is_as_smooth_as_a_solid() -> None:
    ball = trimesh.creation.icosphere(2, 1.0)
    turned = seen(ball, "sunlight", "shadows", turn=Rotation.from_euler("ZYX", [0.7, -0.4, 1.9]))
    solid = green(seen(ball, "sunlight", "shadows"))
    assert np.quantile(np.abs(green(turned) - solid) / solid.max(), 0.995) < 1e-4


def test_geometry_keeps_the_facets_and_a_box_its_edges() -> None:
    picture = seen(trimesh.creation.icosphere(1, 1.0), "sunlight")
    normals = np.asarray(picture.normals_world)[np.asarray(picture.labels) > 1]
    assert len(np.unique(normals.round(5), axis=0)) < 40
    box = green(seen(trimesh.creation.box((1, 1, 1)), "sunlight"))
    assert len(np.unique(box[box > 0].round(3))) <= 3


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
