"""Obstacles are closed solids with the requested size and position."""

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from uwsim import _core
from uwsim.scenario import ScenarioError, Terrain
from uwsim.scenario.build.solids import SIDES, obstacle_solid
from uwsim.scenario.obstacles.pipeline import swept_tube
from uwsim.scenario.spec.obstacle import ObstacleSpec, Solid

SLOPE = 0.2
X, Y = np.meshgrid(np.linspace(-50, 50, 101), np.linspace(-50, 50, 101))
BED = Terrain((SLOPE * X - 30).astype(np.float32), 1.0, (-50.0, -50.0))
POLYGON_AREA = SIDES / 2 * np.sin(2 * np.pi / SIDES)
"""Area of the regular polygon that approximates a unit circle."""


def solid(**settings: object) -> Solid:
    return obstacle_solid(TypeAdapter(ObstacleSpec).validate_python({"name": "it", **settings}), BED)


def build(**settings: object) -> trimesh.Trimesh:
    vertices, triangles, _ = solid(**settings)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume > 0
    return mesh


def is_hit(mesh: trimesh.Trimesh, origin_m: list[float]) -> bool:
    """Return True if a northward ray hits the mesh."""
    world = _core.World()
    world.add_solid("it", mesh.vertices, mesh.faces)
    return bool(np.isfinite(_core.RayScene(world).cast([origin_m], [[0, 1, 0]], 100.0).ranges_m[0]))


def test_boxes_and_cylinders_have_their_size_and_pose() -> None:
    box = build(kind="box", size_m=[4, 2, 1], position_m=[1, 2, -5], yaw_pitch_roll_deg=[90, 0, 0])
    np.testing.assert_allclose(box.bounds, [[0, 0, -5.5], [2, 4, -4.5]], atol=1e-9)
    lying = build(kind="cylinder", radius_m=0.5, length_m=6, position_m=[0, 0, -5], yaw_pitch_roll_deg=[30, 90, 0])
    assert lying.volume == pytest.approx(6 * POLYGON_AREA / 4)
    reach = 3 * np.array([np.cos(np.radians(30)), np.sin(np.radians(30))])
    np.testing.assert_allclose(lying.vertices[:, :2].max(axis=0), reach + 0.5 * reach[::-1] / 3, atol=0.02)


def test_a_ring_is_a_torus_that_can_be_flown_through_along_its_x() -> None:
    ring = build(
        kind="ring", major_radius_m=3, minor_radius_m=0.5, position_m=[1, 2, -9], yaw_pitch_roll_deg=[90, 0, 0]
    )
    np.testing.assert_allclose(ring.bounds, [[-2.5, 1.5, -12.5], [4.5, 2.5, -5.5]], atol=1e-9)
    assert ring.volume == pytest.approx(2 * np.pi * 3 * POLYGON_AREA * 0.25, rel=2e-3)  # Pappus
    assert not is_hit(ring, [1, -5, -9])
    assert is_hit(ring, [1, -5, -6])
    assert is_hit(ring, [3.8, -5, -9])


@given(bend_deg=st.floats(-120, 120), climb=st.floats(-0.5, 0.5), radius_m=st.floats(0.1, 1.0))
def test_a_mitred_tube_keeps_its_cross_section(bend_deg: float, climb: float, radius_m: float) -> None:
    """A mitred prism's volume is the area of its section times the length of its axis, whatever the bends (Pappus)."""
    bend = np.radians(bend_deg)
    axis = np.array([[0, 0, 0], [20, 0, 0], [20 + 20 * np.cos(bend), 20 * np.sin(bend), 20 * climb]])
    tube = trimesh.Trimesh(*swept_tube(axis, radius_m), process=False)
    assert tube.is_watertight
    assert tube.is_winding_consistent
    length = 20 + 20 * np.hypot(1, climb)
    assert tube.volume == pytest.approx(POLYGON_AREA * radius_m**2 * length, rel=1e-9)


@pytest.mark.parametrize("buried", [0.0, 0.25, 0.5])
def test_a_pipeline_lies_on_the_bed_buried_by_its_fraction(buried: float) -> None:
    pipe = build(kind="pipeline", points_m=[[-30, 5], [0, 5], [20, -10]], radius_m=0.5, buried_fraction=buried)
    top = pipe.vertices[:, 2] - BED.height_at(pipe.vertices[:, :2])
    level = np.hypot(1, SLOPE)  # the pipe climbs with the bed, so its cross-section is inclined
    assert top.max() == pytest.approx(0.5 * (1 - 2 * buried) + 0.5 * level, abs=0.02)
    assert top.min() == pytest.approx(0.5 * (1 - 2 * buried) - 0.5 * level, abs=0.02)


def test_a_gate_stands_on_the_bed_with_an_open_passage() -> None:
    gate = build(kind="gate", position_m=[10, 0], yaw_deg=90, width_m=6, height_m=5, bar_radius_m=0.1)
    bed = SLOPE * 10 - 30
    low, high = gate.bounds
    assert high[2] == pytest.approx(bed + 5 + 0.1)
    assert low[2] == pytest.approx(SLOPE * 7 - 30 - 0.5)
    np.testing.assert_allclose([low[:2], high[:2]], [[6.9, -0.1], [13.1, 0.1]], atol=1e-6)
    assert not is_hit(gate, [10, -3, bed + 2.5])
    assert is_hit(gate, [10, -3, bed + 5])
    assert is_hit(gate, [7, -3, bed + 1])
    barred = build(kind="gate", position_m=[10, 0], yaw_deg=90, width_m=6, height_m=5, lower_bar_m=2.5)
    assert is_hit(barred, [10, -3, bed + 2.5])


def test_an_obstacle_outside_the_terrain_is_refused() -> None:
    with pytest.raises(
        ScenarioError, match=r"obstacle 'it': \(5\d, 0\) m lies outside the terrain, which reaches from"
    ):
        build(kind="pipeline", points_m=[[40, 0], [60, 0]], radius_m=0.3)


@pytest.mark.parametrize(
    ("settings", "rule"),
    [
        ({"kind": "pipeline", "points_m": [[0, 0], [10, 0], [0, 1]], "radius_m": 1}, "the pipe bends by 174 deg"),
        ({"kind": "pipeline", "points_m": [[0, 0], [0, 0]], "radius_m": 1}, "occurs twice in a row"),
        (
            {"kind": "ring", "position_m": [0, 0, -5], "major_radius_m": 1, "minor_radius_m": 1},
            r"below major_radius_m \(1 m\)",
        ),
        ({"kind": "gate", "position_m": [0, 0], "width_m": 1, "height_m": 1, "bar_radius_m": 0.5}, "below half"),
        ({"kind": "gate", "position_m": [0, 0], "width_m": 2, "height_m": 1, "lower_bar_m": 1}, "below height_m"),
    ],
)
def test_impossible_shapes_are_refused(settings: dict[str, object], rule: str) -> None:
    with pytest.raises(ValidationError, match=rule):
        build(**settings)


ROUND = [
    {"kind": "sphere", "position_m": [1, 2, -5], "radius_m": 2},
    {"kind": "cylinder", "position_m": [0, 0, -5], "radius_m": 0.5, "length_m": 3, "yaw_pitch_roll_deg": [20, 50, 0]},
    {"kind": "pipeline", "points_m": [[-30, 5], [0, 5], [20, -10]], "radius_m": 0.5},
    {"kind": "gate", "position_m": [10, 0], "yaw_deg": 30, "width_m": 6, "height_m": 5, "bar_radius_m": 0.2},
]


@pytest.mark.parametrize("settings", ROUND, ids=[str(s["kind"]) for s in ROUND])
def test_a_round_obstacles_mesh_is_half_a_percent_inside_its_shape_at_most(settings: dict[str, object]) -> None:
    """Cast rays along every facet's normal: the exact shape lies on or slightly outside the facet's centre."""
    vertices, triangles, shapes = solid(**settings)
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    world = _core.World()
    world.add_solid("it", vertices, triangles, shapes)
    scene, radius_m = _core.RayScene(world), shapes[0].radius_m
    faces = mesh.area_faces > 1e-3 * mesh.area_faces.mean()
    middles, normals = mesh.triangles_center[faces], mesh.face_normals[faces]
    hits = scene.cast(middles + 2 * radius_m * normals, -normals, 3 * radius_m)
    outside = 2 * radius_m - hits.ranges_m
    # Next to a gate's bar another bar may be nearer; next to a pipe, its section beyond a bend.
    alone = settings["kind"] in ("sphere", "cylinder")
    assert (outside > -1e-5).all()
    near = outside < 0.0051 * radius_m + 1e-5
    assert near.all() if alone else near.mean() > 0.5


def test_a_pipelines_exact_shape_bends_where_its_mesh_does() -> None:
    """Rays hit both or miss both, except those passing within half a percent of the radius from the surface."""
    vertices, triangles, shapes = solid(kind="pipeline", points_m=[[-30, 5], [0, 5], [5, -15]], radius_m=0.5)
    round_world, faceted = _core.World(), _core.World()
    round_world.add_solid("it", vertices, triangles, shapes)
    faceted.add_solid("it", vertices, triangles)
    random = np.random.default_rng(0)
    aims = vertices[random.integers(len(vertices), size=4000)]
    origins = aims + random.normal(size=aims.shape) * 3
    directions = aims + random.normal(scale=0.3, size=aims.shape) - origins
    exact, flat = (_core.RayScene(w).cast(origins, directions, 50.0).ranges_m for w in (round_world, faceted))
    both = np.isfinite(exact) & np.isfinite(flat)
    assert both.mean() > 0.3
    assert (np.isfinite(exact) != np.isfinite(flat)).mean() < 0.02
    assert np.median(np.abs(exact[both] - flat[both])) < 0.01 * 0.5, "along the ray, which meets the surface at a slant"
    assert (exact[both] < flat[both] + 1e-5).mean() > 0.95, "the mesh lies inside, but a few rays start in the bore"
