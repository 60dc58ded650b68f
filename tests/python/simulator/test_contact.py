"""Collision shapes: chosen in the vehicle model, read from files, and used for contact in the simulator."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh

from uwsim.scenario import Scenario, ScenarioError, VehicleModel, load_vehicle, vehicle_hull
from uwsim.scenario.build.collision_pieces import load_pieces, vehicle_pieces, write_pieces
from uwsim.simulator.simulator import Simulator


def portal_pieces() -> list[np.ndarray]:
    """Return three boxes that form a gate, open below and along x."""
    boxes = [((0.4, 0.1, 0.6), (0, 0.35, 0)), ((0.4, 0.1, 0.6), (0, -0.35, 0)), ((0.4, 0.8, 0.1), (0, 0, 0.25))]
    return [trimesh.creation.box(size).vertices + np.array(centre) for size, centre in boxes]


def portal(folder: Path, collision: str) -> VehicleModel:
    """Return a neutrally buoyant body with the volume of its bounding box and the given collision shape."""
    trimesh.creation.box((0.4, 0.8, 0.6)).export(folder / "hull.stl")
    write_pieces(portal_pieces(), folder / "hull.pieces.obj", made_from="hull.stl")
    figures = dict.fromkeys(("centre_of_mass_m", "max_force_n", "max_torque_nm"), (0, 0, 0))
    figures |= dict.fromkeys(("linear_damping", "quadratic_damping"), (0,) * 6)
    figures |= {"name": "portal", "mesh": folder / "hull.stl", "collision": collision, "buoyancy": "neutral"}
    figures["added_mass"] = (50, 50, 50, 5, 5, 5)
    if collision == "pieces":
        figures["collision_pieces"] = folder / "hull.pieces.obj"
    return VehicleModel.model_validate(figures)


def simulator(model: VehicleModel | str, start_m: tuple[float, ...] = (0, 0, -10), **changes: Any) -> Simulator:
    terrain = {"source": "noise", "size_m": [40, 40], "spacing_m": 1, "bed_depth_m": 20}
    body = {"name": "body", "model": model, "start": {"position_m": start_m}}
    values = {"name": "contact", "terrain": terrain, "station": {"position_m": [0, 0, 0]}, "vehicles": [body]}
    return Simulator(Scenario.model_validate(values | changes), threads=1)


@pytest.mark.parametrize(("collision", "passes"), [("pieces", True), ("hull", False), ("box", False)])
def test_pieces_leave_the_hollows_of_a_hull_open(tmp_path: Path, collision: str, passes: bool) -> None:
    pipe = {"kind": "pipeline", "name": "pipe", "points_m": [[3, 0], [6, 0]], "radius_m": 0.15}
    sim = simulator(portal(tmp_path, collision), obstacles=[pipe])
    sim.rov.place((0, 0, -19.6), velocity_body=(1, 0, 0, 0, 0, 0))  # astride the pipe on the bed
    sim.advance(6)
    assert (sim.rov.pose.position_world_m[0] > 4) == passes
    assert (sim.rov.collisions == 0) == passes


def test_pieces_survive_writing_and_reading(tmp_path: Path) -> None:
    write_pieces(portal_pieces(), tmp_path / "p.obj", made_from="here")
    pieces = load_pieces(tmp_path / "p.obj")
    assert [len(piece) for piece in pieces] == [8, 8, 8]
    for got, expected in zip(pieces, portal_pieces(), strict=True):
        assert {tuple(v) for v in got.round(5)} == {tuple(v) for v in expected.round(5)}


def test_a_flat_piece_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "flat.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n")
    with pytest.raises(ScenarioError, match="part 1: 4 points in one plane"):
        load_pieces(path)


def test_a_piece_file_is_required_for_pieces_and_refused_without(tmp_path: Path) -> None:
    model = portal(tmp_path, "pieces")
    figures = {key: getattr(model, key) for key in model.model_fields_set}
    with pytest.raises(ValueError, match="uwsim vehicle decompose"):
        VehicleModel.model_validate({**figures, "collision_pieces": None})
    with pytest.raises(ValueError, match="only for `collision: pieces`"):
        VehicleModel.model_validate({**figures, "collision": "hull"})


def test_the_packaged_pieces_fit_their_hull() -> None:
    model = load_vehicle("bluerov2_heavy")
    vertices, triangles = vehicle_hull(model)
    pieces = vehicle_pieces(model)
    low, high = vertices.min(axis=0) - 0.02, vertices.max(axis=0) + 0.02
    assert all((piece >= low).all() and (piece <= high).all() for piece in pieces)
    filled = sum(trimesh.convex.convex_hull(piece).volume for piece in pieces)
    hull = trimesh.Trimesh(vertices, triangles, process=False)
    assert hull.volume < filled < 0.7 * hull.convex_hull.volume


def test_decomposing_twice_gives_the_same_pieces() -> None:
    pytest.importorskip("coacd")
    from uwsim.scenario.build.collision_pieces import decompose

    shape = trimesh.creation.annulus(0.2, 0.5, 0.3, sections=12)
    first, second = (decompose(shape.vertices, shape.faces, max_pieces=6) for _ in range(2))
    assert 2 <= len(first) <= 6
    assert all(np.array_equal(a, b) for a, b in zip(first, second, strict=True))


def test_a_vehicle_dropped_on_the_bed_comes_to_rest(tmp_path: Path) -> None:
    model = portal(tmp_path, "pieces")
    figures = {key: getattr(model, key) for key in model.model_fields_set - {"buoyancy"}}
    sim = simulator(VehicleModel.model_validate(figures | {"density_kg_m3": 1500, "linear_damping": (20,) * 6}))
    sim.rov.place((0.3, 0.2, -19))
    sim.advance(10)
    before = sim.rov.pose.position_world_m
    sim.advance(5)
    assert np.linalg.norm(sim.rov.pose.position_world_m - before) < 1e-4
    assert -20 + 0.3 <= before[2] < -20 + 0.3 + 0.0011  # README: accurate to a millimetre
    assert sim.rov.telemetry().collision_warning


def test_a_light_vehicle_left_on_the_bed_is_at_rest_two_seconds_after_it_was_slow() -> None:
    """A BlueROV2 Heavy weighs 1 N in fresh water: it rocks on two corners, with little friction to stop it."""
    hills = {"hill_height_m": 1, "hill_wavelength_m": 20, "bed_depth_m": 9}
    terrain = {"source": "noise", "seed": 3, "size_m": [60, 60], "spacing_m": 0.5} | hills
    sim = simulator("bluerov2_heavy", (0, 0, -5), water={"density_kg_m3": 1000}, terrain=terrain)
    for x, y in np.random.default_rng(4).uniform(-12, 12, (6, 2)):
        sim.rov.place((x, y, -7.5))
        moved_s = sim.time_s
        while sim.time_s - moved_s < 30:
            sim.advance(0.1)
            linear, angular = sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s
            is_slow = np.linalg.norm(linear) + 0.4 * np.linalg.norm(angular) < 0.01
            if not is_slow or not sim.rov.telemetry().collision_warning:
                moved_s = sim.time_s
            elif not np.any(linear) and not np.any(angular):
                break
        assert sim.time_s - moved_s < 2, f"dropped at {x:.1f}, {y:.1f}"
        before = sim.rov.pose
        sim.advance(20)
        assert np.array_equal(sim.rov.pose.position_world_m, before.position_world_m)
        assert np.array_equal(sim.rov.pose.orientation_xyzw, before.orientation_xyzw)
