"""Growth moves a surface outward by the table's thickness; a pipeline's condition puts joints and defects on it."""

from math import pi

import numpy as np
import pytest
import trimesh

from uwsim import Simulator
from uwsim.scenario import Scenario, ScenarioError
from uwsim.scenario.build.solids import created, overgrown, thickness_m
from uwsim.scenario.build.terrain import build_terrain
from uwsim.scenario.obstacles.pipeline import Pipeline
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.obstacle import GROWTHS, Growth, Solid, places_by_kind

SITE = {
    "name": "site",
    "terrain": {"source": "noise", "size_m": [80, 60], "spacing_m": 1, "bed_depth_m": 9, "hill_height_m": 0},
    "vehicles": [{"name": "rov", "model": "rov", "start": {"position_m": [-9, -9, -5]}}],
}
PILE = {"kind": "cylinder", "name": "pile", "position_m": [0, 0, -5], "radius_m": 0.5, "length_m": 6}
PIPE = {"kind": "pipeline", "name": "pipe", "points_m": [[-30, 0], [30, 5]], "radius_m": 0.3}


def site(*obstacles: dict) -> Simulator:
    return Simulator(validated(Scenario, SITE | {"obstacles": list(obstacles)}))


@pytest.mark.parametrize(
    ("z_m", "latitude_deg", "age_years", "expected_mm"),
    [
        (-20, 57, 2, 100), (-20, 65, 2, 60), (-60, 57, 9, 50), (-60, 65, 9, 30), (0, 57, 2, 100), (3, 57, 2, 0),
        (-20, 57, 1, 50), (-20, 57, 0, 0),
    ],
)  # fmt: skip
def test_thickness_is_that_of_norsok(z_m: float, latitude_deg: float, age_years: float, expected_mm: float) -> None:
    found = thickness_m(Growth(age_years=age_years, latitude_deg=latitude_deg), np.array([z_m], float))
    assert found * 1e3 == pytest.approx([expected_mm])


@pytest.mark.parametrize("kind", GROWTHS)
def test_the_volume_grows_by_the_layer_of_a_cylinder(kind: str) -> None:
    """With radius r and length L, by pi ((r + t)^2 (L + 2 t) - r^2 L); the surface stays closed."""
    radius, length, thick = 0.5, 6.0, 0.1
    vertices, triangles = created("cylinder", radius, length, 32)
    grown = overgrown(Solid(vertices - [0, 0, 10], triangles, []), Growth(age_years=4, kind=kind))
    mesh = trimesh.Trimesh(grown.vertices, grown.triangles, process=False)
    assert mesh.is_watertight and not grown.shapes
    added = mesh.volume - trimesh.Trimesh(vertices, triangles).volume
    assert added == pytest.approx(pi * ((radius + thick) ** 2 * (length + 2 * thick) - radius**2 * length), rel=0.06)


def test_rays_meet_the_growth_outside_the_bare_surface() -> None:
    eyes = np.column_stack([np.full(200, -3.0), np.zeros(200), np.linspace(-6.5, -3.5, 200)])
    ways = np.tile([1.0, 0.0, 0.0], (200, 1))
    bare = site(PILE).scene.cast(eyes, ways, 10.0).ranges_m
    grown = site(PILE | {"growth": {"age_years": 3}})
    found = bare - grown.scene.cast(eyes, ways, 10.0).ranges_m
    assert bare == pytest.approx(2.5, abs=1e-3)
    assert found.mean() == pytest.approx(0.1, abs=0.025) and 0.01 < found.std() < 0.06
    assert np.array_equal(site(PILE | {"growth": {"age_years": 0}}).scene.cast(eyes, ways, 10.0).ranges_m, bare)
    assert grown.strengths_db["pile"] != site(PILE).strengths_db["pile"], "its backscatter is that of the growth"


def test_a_vehicle_rests_on_the_growth() -> None:
    table = {"kind": "box", "name": "table", "position_m": [0, 0, -8], "size_m": [1, 1, 1]}
    shape = {"kind": "sphere", "name": "ball", "position_m": [0, 0, -6.9], "radius_m": 0.3}
    ball = {"shape": shape, "density_kg_m3": 3000}
    heights = []
    for growth in ({}, {"growth": {"age_years": 2, "kind": "barnacle"}}):
        sim = Simulator(validated(Scenario, SITE | {"obstacles": [table | growth], "objects": [ball]}))
        sim.advance(2.0)
        heights.append(float(sim.objects["ball"].pose.position_world_m[2]))
    assert heights[1] - heights[0] == pytest.approx(0.1, abs=0.06)


def test_a_leak_is_a_mark_from_which_bubbles_rise() -> None:
    leak = {"kind": "leak", "at_m": 30.0, "rate_l_min": 5.0}
    sim = site(PIPE | {"condition": {"features": [leak]}}, PILE)
    source = places_by_kind(sim.scenario.obstacles[0].parts(build_terrain(sim.scenario.terrain)))["leak"][0]
    assert sim.label_names[-1] == "pipe leak"
    at, _ = sim.world.school_at(0, 77.0)
    assert at[:, 2].min() >= source[2] and at[:, 2].max() <= 0
    assert np.median(np.linalg.norm(at[:, :2] - source[:2], axis=1)) < 0.1 * -source[2]
    sim.rov.release()
    sim.rov.place(np.add(source, (-2.5, 0, 1.5)), (0, 0, 0, 1))
    frame = sim.rov.cameras["front"].resized(320, 240).capture(geometry_only=True)
    bubbles = frame.label_names.index("pipe leak")
    assert (frame.labels == bubbles).sum() > 50
    assert {frame.class_names[k] for k in np.unique(frame.classes[frame.labels == bubbles])} == {"bubbles"}
    rays = np.repeat([[0.0, 0.0, 1.0]], 400, axis=0)
    from_m = source + np.column_stack([np.random.default_rng(1).normal(0, 0.05, (400, 2)), np.full(400, 0.2)])
    assert bubbles in sim.around().scene.cast(from_m, rays, 10.0).labels


def test_a_leak_above_the_water_is_refused() -> None:
    ashore = {"terrain": SITE["terrain"] | {"rim": {"height_m": 16, "width_m": 20}}}
    leaks = PIPE | {"points_m": [[-38, 0], [30, 5]], "condition": {"features": [{"kind": "leak", "at_m": 2}]}}
    with pytest.raises(ScenarioError, match="must be under water"):
        Simulator(validated(Scenario, SITE | ashore | {"obstacles": [leaks]}))


def test_a_pipe_has_joints_anodes_and_features_where_they_were_put() -> None:
    condition = {
        "features": [{"kind": "damage", "at_m": 20.0, "clock_h": 12}, {"kind": "span", "at_m": 40.0, "height_m": 0.5}]
    }
    sim = site(PIPE | {"condition": condition})
    pipe = sim.scenario.obstacles[0]
    ahead = np.array([60.0, 5.0, 0]) / np.hypot(60, 5)
    top_m = -9 + 0.3 * 0.6 + 0.3  # a fifth of the diameter is in the bed

    def top(at_m: float) -> float:
        eye = np.array([-30.0, 0.0, -5.0]) + at_m * ahead
        return -5.0 - float(sim.scene.cast(eye[None], np.array([[0.0, 0.0, -1.0]]), 10.0).ranges_m[0])

    assert top(5.0) == pytest.approx(top_m, abs=5e-3)
    assert top(12.2) == pytest.approx(top_m - 0.06 * 0.3, abs=5e-3), "a field joint"
    assert top(6.1) == pytest.approx(top_m + 0.12 * 0.3, abs=5e-3), "an anode"
    assert top(20.0) == pytest.approx(top_m - 0.12 * 0.3, abs=5e-3), "damage"
    assert top(40.0) == pytest.approx(top_m + 0.5, abs=0.01), "a span"
    marks = places_by_kind(pipe.parts(build_terrain(sim.scenario.terrain)))
    assert {kind: len(places) for kind, places in marks.items()} == {"damage": 1, "span": 1, "anode": 3, "joint": 4}
    assert marks["damage"][0] == pytest.approx(np.array([-30, 0, top_m]) + 20 * ahead, abs=0.01)
    solid = pipe.solid(build_terrain(sim.scenario.terrain))
    assert trimesh.Trimesh(solid.vertices, solid.triangles, process=False).is_watertight
    texture = pipe.texture()
    assert texture is not None and len(texture[1]) == len(solid.triangles)


def test_a_seed_draws_features_that_do_not_overlap() -> None:
    def pipe(seed: int) -> list[list[float]]:
        condition = {"damages": 4, "spans": 2, "burials": 1, "seed": seed}
        terrain = site().scenario.terrain
        parts = validated(Pipeline, PIPE | {"condition": condition}).parts(build_terrain(terrain))
        return places_by_kind(parts)["damage"].tolist()

    assert pipe(1) == pipe(1) != pipe(2)
    assert len(pipe(1)) == 4


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        ({"growth": {"age_years": -1}}, "age_years = -1.*must be in"),
        ({"growth": {"age_years": 1, "latitude_deg": 20}}, "latitude_deg = 20"),
        ({"condition": {"features": [{"kind": "span", "at_m": 90}]}}, "must be at most 60.2"),
        ({"condition": {"spans": 40}}, "no room for another span"),
        ({"condition": {"features": [{"kind": "leak", "at_m": 9, "rate_l_min": -1}]}}, "rate_l_min = -1 l/min"),
        ({"condition": {"features": [{"kind": "span", "at_m": 9}, {"kind": "span", "at_m": 12}]}}, "features overlap"),
    ],
)
def test_what_cannot_be_is_refused(wrong: dict, rule: str) -> None:
    with pytest.raises(ScenarioError, match=rule):
        site(PIPE | wrong)
