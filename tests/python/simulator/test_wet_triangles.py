"""Wet triangles: their area and their push have the closed forms, and the push is the buoyancy that moves the body."""

from math import pi

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from test_forces import puddle
from test_loose_bodies import body, site
from uwsim import Simulator
from uwsim.scenario.build.hull import vehicle_hull
from uwsim.scenario.spec.vehicle import load_vehicle

LONG_WAVES = {"surface": {"kind": "airy", "amplitude_m": 0.2, "period_s": 4.0, "heading_deg": 30.0}}
SHORT_WAVES = {"surface": {"kind": "airy", "amplitude_m": 0.01, "period_s": 0.75}}


def hull_of(model: str) -> np.ndarray:
    vertices, triangles = vehicle_hull(load_vehicle(model))
    return vertices[triangles]


def area_m2(triangles: np.ndarray) -> float:
    a, b, c = triangles.transpose(1, 0, 2)
    return 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()


def test_a_box_and_a_sphere_half_under_water_are_wet_below_their_middle() -> None:
    sim = site(
        body("box", "box", [0, 0, 0], density_kg_m3=500.0), body("sphere", "ball", [5, 0, 0], density_kg_m3=500.0)
    )
    gravity = sim.world.water.gravity_m_s2
    box, ball = (sim.objects[name].wet_triangles() for name in ("box", "ball"))
    assert box.area_m2 == pytest.approx(1.0 * 0.8 + 2 * (1.0 + 0.8) * 0.3, rel=1e-12)
    assert box.forces_body_n.sum(axis=0) == pytest.approx([0, 0, 1000.0 * gravity * 0.24], abs=1e-9)
    assert ball.area_m2 == pytest.approx(2 * pi * 0.2**2, rel=0.01)  # the sphere is a mesh
    assert ball.forces_body_n[:, 2].sum() == pytest.approx(1000.0 * gravity * 2 / 3 * pi * 0.2**3, rel=0.02)
    sim.objects["ball"].apply_wrench([0.0, 0.0, -1e3])
    sim.advance(1.0)
    whole = sim.objects["ball"].wet_triangles()
    assert whole.area_m2 == pytest.approx(2 * ball.area_m2, rel=1e-9), "all of it is under water"


@pytest.mark.parametrize("height_m", [-2.0, -0.05, 0.0, 0.05, 2.0])
def test_the_push_is_the_force_and_the_moment_of_archimedes_at_any_attitude(height_m: float) -> None:
    sim = puddle()
    for seed in range(5):
        turn = Rotation.random(random_state=seed)
        sim.rov.place([3.0, -2.0, height_m], turn.as_quat())
        wet, buoyancy = sim.rov.wet_triangles(), sim.rov.forces["buoyancy"]
        assert wet.forces_body_n.sum(axis=0) == pytest.approx(buoyancy.force_body_n, rel=1e-10, abs=1e-9)
        corners = wet.corners_body_m
        pressures = (
            -sim.world.water.density_at_kg_m3(0.0)
            * sim.world.water.gravity_m_s2
            * ((corners @ turn.as_matrix()[2]) + height_m)
        )
        normals = -0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        sums = corners.sum(axis=1, keepdims=True) + corners  # integral of p r over a triangle where p is linear
        lever = np.einsum("nk,nki->ni", pressures, sums) / 12
        torque = np.cross(lever, normals).sum(axis=0)
        assert torque == pytest.approx(buoyancy.torque_body_nm, rel=1e-9, abs=1e-9)


def test_the_wet_part_is_that_which_trimesh_cuts_off() -> None:
    hull = trimesh.Trimesh(*vehicle_hull(load_vehicle("bluerov2_heavy")), process=False)
    sim = puddle()
    for seed in range(5):
        turn = Rotation.random(random_state=seed)
        sim.rov.place([0.0, 0.0, 0.03], turn.as_quat())
        up = turn.as_matrix()[2]
        judged = hull.slice_plane(-0.03 * up, -up)
        assert sim.rov.wet_triangles().area_m2 == pytest.approx(judged.area, rel=1e-9)


@pytest.mark.filterwarnings("ignore:vehicle .* starts at the surface")
@pytest.mark.parametrize(("waves", "tolerance"), [(LONG_WAVES, 0.02), (SHORT_WAVES, 0.1)])
def test_in_waves_the_wet_part_lies_below_the_surface_and_pushes_like_the_volume(waves: dict, tolerance: float) -> None:
    sim = puddle(water=waves, vehicle={"model": "remus100", "start": {"position_m": [0, 0, -0.02]}})
    hull_m2 = area_m2(hull_of("remus100"))
    for k in range(8):
        surface_m = sim.world.water.surface_height_m([[0.3 * k, 0.1 * k]], 0.0)[0]
        sim.rov.place([0.3 * k, 0.1 * k, surface_m - 0.02], Rotation.from_euler("zyx", [0.4 * k, 0.05, 0.0]).as_quat())
        wet = sim.rov.wet_triangles()
        pose = sim.rov.pose
        centres = wet.corners_body_m.mean(axis=1) @ pose.world_from_body[:3, :3].T + pose.position_world_m
        above_m = centres[:, 2] - sim.world.water.surface_height_m(centres[:, :2], sim.time_s)
        assert above_m.max() < 0.01, "planes instead of the surface: a share of the waves' height"
        assert 0.0 < wet.area_m2 < hull_m2
        pushed, buoyancy = wet.forces_body_n.sum(axis=0), sim.rov.forces["buoyancy"].force_body_n
        assert np.linalg.norm(pushed - buoyancy) < tolerance * np.linalg.norm(buoyancy)
    sim.rov.place([0.0, 0.0, -3.0])
    assert sim.rov.wet_triangles().area_m2 == pytest.approx(hull_m2, rel=1e-12)


def test_paper_buoyant_floats_by_its_wet_triangles_and_rights_itself() -> None:
    sim = Simulator("paper_buoyant")
    sim.rov.place([0.0, -100.0, -2.0], Rotation.from_euler("x", 40, degrees=True).as_quat())
    sim.advance(60.0)
    wet, weight = sim.rov.wet_triangles(), sim.rov.forces["weight"].force_body_n
    assert wet.forces_body_n[:, 2].sum() == pytest.approx(-weight[2], rel=1e-3)
    assert 0.8 < wet.area_m2 / area_m2(hull_of("paper_buoyant")) < 1.0
    assert sim.rov.pose.world_from_body[2, 2] > 0.999
    sim.rov.set_effort(heave=-1.0)
    sim.advance(20.0)
    assert sim.rov.pose.position_world_m[2] < -3.0, "it dives by its own force"


def test_the_cameras_of_paper_buoyant_tilt_and_those_of_the_published_project_do_not() -> None:
    sim = Simulator("paper_buoyant")
    for name in ("front", "down"):
        camera = sim.rov.cameras[name]
        before = camera.world_from_camera[:3, 0]
        camera.aim(tilt_rad=-0.5)
        sim.advance(2.0)
        assert np.arccos(before @ camera.world_from_camera[:3, 0]) == pytest.approx(0.5, abs=0.1), "it bobs meanwhile"
    assert all(camera.mount.pan_tilt is None for camera in Simulator("paper").rov.cameras.values())
