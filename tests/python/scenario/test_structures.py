"""Tests of nets, lines and scour: closed meshes, holes that rays pass, chains and ropes of the right length."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import trimesh

from uwsim.exercises import load_exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.scenario import Scenario, build_terrain, load
from uwsim.scenario.obstacles.lines import Line, Net
from uwsim.scenario.read.errors import ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.simulator.simulator import Simulator

NET = {"kind": "net", "name": "net", "position_m": (2.0, 1.0, -1.0), "radius_m": 3.0, "depth_m": 4.0, "mesh_m": 0.4}
LINE = {"kind": "line", "name": "line", "position_m": (1.0, 0.0, -5.0), "radius_m": 0.05}
PIECE = [[[0, 0, 0], [8, 0, 0]]]


def closed(solid: Any) -> trimesh.Trimesh:
    mesh = trimesh.Trimesh(solid.vertices, solid.triangles, process=False)
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0
    return mesh


@pytest.mark.parametrize("seed", [1, 2])
def test_a_net_has_its_holes_and_no_other(seed: int) -> None:
    net = Net(**NET, holes=3, hole_m=1.2, seed=seed)
    marks = net.holes_m()
    assert np.hypot(*(marks - net.position_m)[:, :2].T) == pytest.approx(3.0)
    assert (np.abs(marks[:, 2] + 3.0) <= 2.0 - 1.2).all()
    torn, whole = closed(net.solid(build_terrain(load("pool").terrain))), closed(Net(**NET).solid(None))  # type: ignore[arg-type]
    away = np.linalg.norm(torn.vertices[:, None] - marks, axis=2)
    assert (away > 0.6 - 0.2 - 0.02).all()
    lost = len(whole.faces) - len(torn.faces)
    assert lost == 8 * round(lost / 8) > 0
    assert not np.array_equal(marks, Net(**NET, holes=3, hole_m=1.2, seed=seed + 2).holes_m())


def test_a_rope_hangs_and_a_chain_has_links_along_it() -> None:
    rope = Line(**LINE, lines_m=PIECE, sag_m=1.0).solid(None)  # type: ignore[arg-type]
    assert rope.vertices[:, 2].min() == pytest.approx(-6.05, abs=2e-3)
    assert len(rope.shapes) == 16
    chain = Line(**LINE, lines_m=PIECE, sag_m=1.0, links=True).solid(None)  # type: ignore[arg-type]
    t = np.linspace(0, 8, 1000)
    length = np.hypot(np.diff(t), np.diff(4 * t / 8 * (1 - t / 8))).sum()
    links = closed(chain).split()
    assert len(links) == pytest.approx(length / 0.25, abs=1)
    step = np.linalg.norm(np.diff([link.centroid for link in links], axis=0), axis=1)
    assert step == pytest.approx(0.25, abs=0.005)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({**NET, "holes": 90, "hole_m": 1.9}, "too many holes for this wall"),
        ({**NET, "strand_m": 0.3}, r"strand_m = 0.3 m: must be below half of mesh_m"),
        ({**NET, "mesh_m": 0.01}, "wall and bottom have [0-9]+ knots"),
        ({**NET, "radius_m": 150.0, "depth_m": 0.02, "mesh_m": 0.02, "strand_m": 0.002}, "bottom have [0-9]+ knots"),
        ({**LINE, "lines_m": [[[0, 0, 0], [0, 0, 0]]]}, "a point occurs twice in a row"),
        ({**LINE, "lines_m": [[[0, 0, 0], [9000, 0, 0]]], "links": True}, "at most 5000 links"),
        ({**LINE, "lines_m": PIECE, "links": True, "sag_m": 1000.0}, "at most 5000 links"),
        ({**LINE, "lines_m": [[[k, 0, 0] for k in range(200)]] * 40, "sag_m": 1.0}, "at most 100000 bars"),
    ],
)
def test_mistakes_are_reported(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message):
        validated(Scenario, {**load("pool").given(), "obstacles": [change]})


def test_scour_is_a_hole_with_a_floor_and_an_even_slope() -> None:
    plain = load("pool").terrain.given()
    hole = {"position_m": (2.0, -1.0), "radius_m": 1.0, "depth_m": 2.0, "slope_deg": 45.0}
    bed = build_terrain(validated(type(load("pool").terrain), {**plain, "scour": (hole,)}))
    at = [[2.0, -1.0], [2.5, -1.0], [4.0, -1.0], [2.0, 1.5], [6.0, -1.0]]
    assert bed.height_at(at) - build_terrain(load("pool").terrain).height_at(at) == pytest.approx([-2, -2, -1, -0.5, 0])


def test_rays_pass_a_hole_and_meet_a_strand() -> None:
    net = {**NET, "position_m": (0.0, 0.0, -0.2), "strand_m": 0.1, "holes": 1, "hole_m": 1.4}
    with Simulator(validated(Scenario, {**load("pool").given(), "obstacles": [net]})) as sim:
        (mark,) = Net(**net).holes_m()
        out = mark * [1, 1, 0] / 3.0
        strand = np.array([3.0 * out[1], -3.0 * out[0], -2.2])  # a row of knots at mid-depth, a quarter around
        eyes, ways = np.array([mark + 0.5 * out, 1.2 * strand * [1, 1, 1 / 1.2]]), np.array([-out, -strand * [1, 1, 0]])
        through, met = sim.scene.cast(eyes, ways, 2.0).ranges_m
    assert through > 1.0
    assert met == pytest.approx(0.6, abs=0.06)


def test_only_an_obstacle_with_something_to_find_can_be_searched() -> None:
    found = load_exercise("net-inspection")
    goal = found.goals[0].model_copy(update={"obstacle": "pen_east"})
    with pytest.raises(ValueError, match=r"goals\[0\]: obstacle = 'pen_east': must be .* to find: pen_west"):
        fly_exercise(found.model_copy(update={"goals": [goal]}), lambda vehicle: None)
