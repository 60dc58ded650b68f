"""Props: what they consist of behaves, and stands where the scenario places them."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

import uwsim
from uwsim.scenario import ScenarioError, load
from uwsim.scenario.obstacles.board import Board
from uwsim.scenario.read.assets import packaged_names
from uwsim.scenario.spec.prop import PropEntry

POOL: dict[str, Any] = {
    "name": "pool",
    "water": {"density_kg_m3": 1000},
    "terrain": {"source": "noise", "size_m": [40, 40], "bed_depth_m": 3, "hill_height_m": 0},
    "vehicles": [{"name": "rov", "model": "bluerov2_heavy", "start": {"position_m": [-10, 0, -1.5]}}],
}
FLOOR = -3.0


def pool(*props: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {**POOL, "props": list(props), **more}


def prop(model: str | Path, at: tuple[float, float, float] = (0, 0, FLOOR), **more: Any) -> dict[str, Any]:
    return {"name": "it", "model": str(model), "position_m": at, **more}


def ball(at: tuple[float, float, float], speed: tuple[float, float, float] = (0, 0, 0), **more: Any) -> dict[str, Any]:
    shape = {"kind": "sphere", "name": "ball", "position_m": at, "radius_m": 0.04}
    return {"shape": shape, "density_kg_m3": 2000, "velocity_m_s": speed, **more}


def board_of(size_m: tuple[float, float], **more: Any) -> Board:
    return Board.model_validate({"kind": "board", "name": "it", "position_m": (0, 0, 0), "size_m": size_m, **more})


def after(seconds: float, scenario: dict[str, Any], body: str) -> np.ndarray[Any, Any]:
    with uwsim.Simulator(scenario) as sim:
        sim.advance(seconds)
        return np.array(sim.objects[body].pose.position_world_m)


@pytest.mark.parametrize("name", packaged_names("props"))
def test_each_states_its_source_and_stands_in_a_pool(name: str) -> None:
    entry = PropEntry.model_validate(prop(name, (0, 0, 0 if name == "octagon" else FLOOR)))
    assert entry.model.name == name and len(entry.model.source.split()) > 5
    with uwsim.Simulator({**POOL, "props": [entry]}) as sim:
        sim.advance(0.5)
        assert len(sim.objects) == len(entry.model.objects)


def test_parts_stand_where_a_turn_about_the_vertical_puts_them() -> None:
    scenario = load(pool(prop("gate_two_sides", (4, 2, FLOOR), yaw_deg=90, name="gate")))
    places: dict[str, Any] = {one.name: one for one in scenario.obstacles}
    # Its own y axis leads west now: the red leg stands west of the middle, 1.4 m above the floor.
    assert places["gate_leg_left"].position_m == pytest.approx((4 - 1.525, 2, FLOOR + 1.4))
    assert places["gate_sign_left"].yaw_pitch_roll_deg == pytest.approx((90, 0, 0))
    again = load(scenario.given())
    assert again.obstacles == scenario.obstacles and not again.props


def test_a_prop_that_leans_does_so_as_one_for_rays_pictures_and_contacts() -> None:
    turn = {"yaw_deg": 30.0, "pitch_deg": 4.0, "roll_deg": -6.0}
    rotation = Rotation.from_euler("ZYX", list(turn.values()), degrees=True)
    at, level = np.array([4.0, 2.0, FLOOR]), load(pool(prop("torpedo_board")))
    leans = load(pool(prop("torpedo_board", tuple(at), **turn)))
    for one, other in zip(level.obstacles, leans.obstacles, strict=True):
        near = 1e-9 if one.kind == "board" else 0.01  # a round bar's facets begin where its direction has them
        corners = one.solid(None).vertices - [0, 0, FLOOR]  # type: ignore[arg-type]
        assert other.solid(None).vertices == pytest.approx(rotation.apply(corners) + at, abs=near)  # type: ignore[arg-type]
    # A ball through the middle of an opening, along the board's own normal, passes; a ray, too, but not at its middle.
    ahead, middle = rotation.apply([1.0, 0.0, 0.0]), at + rotation.apply([0.0, -0.15, 1.35])
    with uwsim.Simulator(leans) as sim:
        eyes = np.array([middle, at + rotation.apply([0.0, 0.0, 1.2])]) + ahead
        cast = sim.scene.cast(eyes, np.array([-ahead, -ahead]), 1.1)
    assert np.isinf(cast.ranges_m[0]) and cast.ranges_m[1] == pytest.approx(0.995, abs=1e-5)
    start = tuple((middle + 0.4 * ahead).tolist())
    thrown = pool(prop("torpedo_board", tuple(at), **turn), objects=[ball(start, tuple((-4 * ahead).tolist()))])
    assert (after(0.4, thrown, "ball") - middle) @ ahead < -0.1
    assert load(leans.given()).obstacles == leans.obstacles


def test_a_prop_is_painted_where_it_states_no_colour() -> None:
    blue = (0.04, 0.12, 0.55)
    scenario = load(pool(prop("flare_with_ball", colour=blue)))
    foot, golf_ball = scenario.objects
    assert foot.shape.material.colour == blue and foot.links is not None
    assert {link.shape.material.colour for link in foot.links.values() if link.shape is not None} == {blue}
    assert golf_ball.shape.material.colour == (0.8, 0.8, 0.8)


def test_a_drum_receives_a_ball_and_what_falls_beside_it_stays_out() -> None:
    for x_m, is_in in ((0.1, True), (0.45, False)):
        x, y, z = after(4.0, pool(prop("drum"), objects=[ball((x_m, 0, FLOOR + 0.6))]), "ball")
        assert (np.hypot(x, y) < 0.3) == is_in and z < FLOOR + 0.3


def test_a_lid_keeps_a_ball_out_and_what_floats_beneath_lifts_it() -> None:
    assert after(3.0, pool(prop("bin_with_lid"), objects=[ball((0, 0, FLOOR + 0.5))]), "ball")[2] > FLOOR + 0.2
    light = ball((0.05, 0, FLOOR + 0.1))
    light["shape"]["radius_m"], light["density_kg_m3"] = 0.07, 100
    assert after(4.0, pool(prop("bin_with_lid"), objects=[light]), "ball")[2] > FLOOR + 1.0


def test_a_flare_keeps_its_golf_ball_until_it_is_bumped() -> None:
    rim_top_m, rim_m, ball_m = 0.015 + 0.02 + 0.755 + 0.016 + 0.006, 0.017, 0.02135  # it rests on the rim's inner edges
    height_m = rim_top_m + np.sqrt(ball_m**2 - rim_m**2)
    assert after(5.0, pool(prop("flare_with_ball")), "it_golf_ball")[2] == pytest.approx(FLOOR + height_m, abs=0.001)
    bumped = pool(prop("flare_with_ball"), objects=[ball((-0.5, 0, FLOOR + 0.6), (2.0, 0, 0.3))])
    assert after(5.0, bumped, "it_golf_ball")[2] < FLOOR + 0.1


def test_a_board_lets_through_what_fits_its_opening() -> None:
    board = {"kind": "board", "name": "board", "position_m": [0, 0, -1.5], "size_m": [1, 1]}
    board["openings"] = [{"at_m": [0.2, 0.1], "radius_m": 0.1}]
    for y_m, passes in ((0.2, True), (-0.2, False)):
        thrown = pool(obstacles=[board], objects=[ball((0.2, y_m, -1.38), (-4, 0, 0))])
        assert (after(0.5, thrown, "ball")[0] < -0.1) == passes


def test_a_board_is_closed_and_as_large_as_stated() -> None:
    openings = [{"at_m": at, "radius_m": r} for at, r in (((-0.3, 0.1), 0.1), ((0.3, 0.1), 0.15), ((0.3, -0.25), 0.08))]
    board = board_of((1.2, 0.8), openings=openings)
    vertices, triangles, _ = board.solid(None)  # type: ignore[arg-type]  # it does not stand on the bed
    solid = trimesh.Trimesh(vertices, triangles, process=False)
    assert solid.is_watertight and np.ptp(vertices, axis=0) == pytest.approx((0.02, 1.2, 0.8))
    chords = np.sin(2 * np.pi / 32) / (2 * np.pi / 32)  # a circle's polygon of 32 corners
    hole_m2 = np.pi * (0.1**2 + 0.15**2 + 0.08**2) * chords
    assert solid.volume == pytest.approx(0.02 * (1.2 * 0.8 - hole_m2), rel=1e-9)


def test_a_mark_covers_its_area_and_reads_from_left_to_right() -> None:
    marks = [{"shape": "disc", "size_m": 0.4, "at_m": [-0.25, 0.1], "colour": [1, 0, 0]}]
    marks += [{"shape": "text", "text": "L", "size_m": 0.7, "at_m": [0.3, 0], "colour": [0, 0, 1]}]
    board = board_of((1, 1), marks=marks)
    texture = board.texture()
    assert texture is not None
    picture = texture.image[:, : texture.image.shape[0]].astype(int)
    red, blue = picture[:, :, 0] - picture[:, :, 2] > 128, picture[:, :, 2] - picture[:, :, 0] > 128
    assert red.mean() == pytest.approx(np.pi * 0.2**2, rel=0.01)
    assert np.argwhere(red).mean(axis=0) / len(red) == pytest.approx((0.4, 0.25), abs=0.01)  # from the top left
    columns = blue.mean(axis=0)
    assert columns.argmax() / len(blue) == pytest.approx(0.05 + 0.5, abs=0.05)  # the stem of an L is at its left
    vertices, triangles, _ = board.solid(None)  # type: ignore[arg-type]
    right = vertices[triangles][:, :, 1]
    front = (vertices[triangles][:, :, 0] > 0).all(axis=1)
    assert texture.corners[front][:, :, 0] == pytest.approx((right[front] + 0.5) * 512 / 516)


GATE = "obstacles: [{kind: gate, name: g, position_m: [0, 0], width_m: 2, height_m: 1}]"
SWIMMER = """objects:
- {shape: {kind: sphere, name: s, position_m: [0, 0, 0], radius_m: 1}, mass_kg: 1, velocity_m_s: [1, 0, 0]}"""


@pytest.mark.parametrize(
    ("text", "rule"),
    [(GATE, "no place of three numbers"), (SWIMMER, "must be left out in a prop"), ("sauce: 1", "sauce")],
)
def test_a_wrong_prop_is_refused_by_its_file_and_key(tmp_path: Path, text: str, rule: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(f"name: mine\ndescription: d\nsource: our own\n{text}\n")
    with pytest.raises(ScenarioError, match=rule) as raised:
        load(pool(prop(path)))
    assert "mine.yaml" in str(raised.value)
