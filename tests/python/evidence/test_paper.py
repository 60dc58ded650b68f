"""The scenario `paper` behaves like the published simulator; test_reproduce.py has its lawn-mower's flight."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from uwsim import Simulator


@pytest.fixture(scope="module")
def sim():
    return Simulator("paper")


@pytest.fixture
def paper(sim):
    sim.reset()
    return sim


def test_released_it_falls_into_the_water_and_stays_where_its_motion_ends(paper):
    rov = paper.rov
    rov.release()
    paper.advance(0.3)
    assert rov.velocity.linear_body_m_s[2] == pytest.approx(-9.81 * 0.3, rel=0.03)  # free fall in air
    paper.advance(20.0)
    depth_m = -rov.pose.position_world_m[2]
    paper.advance(60.0)
    assert 0.5 < depth_m == pytest.approx(-rov.pose.position_world_m[2], abs=0.02)


def test_motion_decays_at_the_published_rate_of_one_per_second(paper):
    rov = paper.rov
    rov.place([0, -100, -20])
    rov.set_effort(surge=0.02)  # slow: the published drag has no quadratic part
    paper.advance(10.0)
    begin_m_s = rov.velocity.linear_body_m_s[0]
    rov.set_effort()
    paper.advance(2.0)
    assert rov.velocity.linear_body_m_s[0] == pytest.approx(begin_m_s * math.exp(-2.0), rel=0.03)


def test_below_the_cage_it_can_dock_again(paper):
    rov, dock = paper.rov, paper.rov.pose.position_world_m
    rov.release()
    rov.set_effort(heave=0.4)
    paper.advance(30.0)
    rov.dock()
    assert not rov.released
    np.testing.assert_allclose(rov.pose.position_world_m, dock)


def test_the_station_and_the_vehicle_are_where_the_published_scene_has_them(paper):
    # LawnTest.unity: ROV (-9.1, 79.42, 130.5), ControlStation (12.2, 81.7, 139.15); the surface at 75.3
    np.testing.assert_allclose(paper.rov.pose.position_world_m, (9.1, -130.5, 79.42 - 75.3))
    away_m = math.dist((-9.1, 79.42, 130.5), (12.2, 81.7, 139.15))
    assert paper.rov.telemetry().distance_to_station_m == pytest.approx(away_m, abs=0.02)


def test_it_lies_between_mountains_of_many_times_the_height_of_its_station(paper):
    x, y = np.meshgrid(np.arange(-80.0, 121.0), np.arange(-198.0, -19.0))
    heights = paper.world.height_at(np.column_stack([x.ravel(), y.ravel()])).reshape(x.shape)
    around = np.concatenate([heights[0], heights[-1], heights[:, 0], heights[:, -1]])
    assert np.mean(around > 0.0) > 0.8  # an open sea has none
    assert heights.max() > 5 * 18.6  # the station's aerial


def test_gates_are_rings_that_a_vehicle_can_fly_through(paper):
    gates = [item for item in paper.scenario.obstacles if item.name.startswith("gate")]
    assert [gate.kind for gate in gates] == ["ring"] * 4
    for gate in gates:
        yaw = math.radians(gate.yaw_pitch_roll_deg[0])
        ahead, across = (math.cos(yaw), math.sin(yaw), 0.0), (-math.sin(yaw), math.cos(yaw), 0.0)
        ways = np.array([across, np.negative(across), (0, 0, 1), (0, 0, -1), ahead, np.negative(ahead)])
        hits = paper.scene.cast(np.tile(gate.position_m, (6, 1)), ways, 7.0)
        np.testing.assert_allclose(hits.ranges_m[:4], 6.6 - 0.38, atol=0.1)
        assert not np.isfinite(hits.ranges_m[4:]).any()


def test_vehicle_and_station_have_several_colours(paper):
    frame = paper.cameras["station"].capture("off")
    for name, least in (("rov", 3), ("station", 2)):
        pixels = frame.rgb[frame.labels == frame.label_names.index(name)].astype(float)
        shades = np.unique(np.round(pixels / pixels.sum(axis=1, keepdims=True), 1), axis=0)
        assert len(shades) >= least


def test_the_lamp_key_lights_up_the_bed_at_depth(paper):
    rov = paper.rov
    rov.place([10, -100, -37])
    pictures = []
    for rov.lamps["down"].on in (False, True):
        pictures.append(rov.cameras["down"].capture().rgb.astype(int))
    rov.lamps["down"].on = False
    assert np.mean(np.abs(pictures[1] - pictures[0]).max(axis=-1) > 8) > 0.5


@pytest.mark.parametrize(("axis", "row"), [("pitch", 0), ("roll", 1)])
def test_no_righting_moment_holds_roll_and_pitch(paper, axis, row):
    rov = paper.rov
    rov.place([0, -100, -20])
    rov.set_effort(**{axis: 1.0})
    paper.advance(4.0)
    rov.set_effort()
    paper.advance(1.0)
    tilted = rov.pose.world_from_body[2, row]
    assert abs(tilted) > math.sin(math.radians(40))
    paper.advance(5.0)
    assert rov.pose.world_from_body[2, row] == pytest.approx(tilted, abs=0.02)


@pytest.mark.parametrize("height_m", [1.5, 20.0, 39.0])
def test_temperature_and_pressure_follow_the_published_lines(paper, height_m):
    paper.rov.place([0, -100, height_m - 41.5])
    panel = paper.rov.telemetry()
    assert panel.temperature_deg_c == pytest.approx(0.144 * height_m + 18.0, abs=0.03)
    assert 1e-3 * panel.pressure_pa == pytest.approx(101.325 + (41.5 - height_m) * 997 * 9.8 / 1000, rel=0.003)


def test_refraction_moves_pictures_by_up_to_the_published_share_of_their_width(paper):
    paper.rov.place([49.7, -135.5, -18.9], Rotation.from_euler("z", 13.8, degrees=True).as_quat())
    camera = paper.rov.cameras["front"]
    still, moving = (camera.capture([*effects]) for effects in ((), ("wobble",)))
    ring = [(frame.labels == frame.label_names.index("gate_3"))[150:200, :320] for frame in (still, moving)]
    left = [picture.argmax(axis=1) for picture in ring if picture.any(axis=1).all()]
    shift = np.abs(left[1] - left[0]).max()
    assert 1 <= shift <= math.ceil(0.0055 * camera.mount.width)
