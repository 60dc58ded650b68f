"""Boats: they float where Archimedes says, and a log of one is held against its model at the surface."""

from pathlib import Path

import numpy as np
import pytest
import trimesh

from uwsim import Batch
from uwsim.evidence.identification import identify
from uwsim.evidence.vehicle.afloat import afloat
from uwsim.recording.real_flights.beside import fly_beside
from uwsim.recording.real_flights.deep_water import STEP_S, in_deep_water, start_m
from uwsim.recording.real_flights.motion import MotionLog, motion_of
from uwsim.recording.real_flights.read import read_flight
from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.scenario.build.hull import floating_height_m, is_boat, volume_below_m3
from uwsim.simulator.simulator import Simulator

SEA_KG_M3, EVERY = 1025.0, 20
COLUMNS = ("t = time [s], x = east [m], y = north [m], yaw = yaw [rad], u = surge [m/s], v = sway [m/s], "
           "r = yaw rate [rad/s], port = thruster port, starboard = thruster starboard")  # fmt: skip


otter = pytest.fixture(scope="module", name="otter")(lambda: load_vehicle("otter"))


def log_of(model: VehicleModel, folder: Path, rows: int) -> MotionLog:
    """Fly a boat under changing commands, and return what a table without height, roll and pitch states of it."""
    alone, draw, lines = (
        in_deep_water(model, SEA_KG_M3, folder),
        np.random.default_rng(4),
        ["t,x,y,yaw,u,v,r,port,starboard"],
    )
    boat = Batch(alone, n=1)
    boat.place([start_m(alone)])
    for k in range(rows):
        if k % 10 == 0:
            port, starboard = draw.uniform(0.2, 0.9, 2)
            boat.set_thrusters({"port": port, "starboard": starboard})
        at = boat.observe()
        (x, y, _), (_, _, z, w), (u, v, _, _, _, r) = (
            each[0] for each in (at.position_world_m, at.orientation_xyzw, at.velocity_body)
        )
        row = k * EVERY * STEP_S, x, y, 2.0 * np.arctan2(z, w), u, v, r, port, starboard
        lines.append(",".join(f"{value:.6f}" for value in row))
        boat.step(EVERY)
    (folder / "boat.csv").write_text("\n".join(lines) + "\n")
    return motion_of(read_flight(folder / "boat.csv", COLUMNS), model)[0]


def test_a_closed_hull_s_volume_below_a_height_is_that_of_the_solid() -> None:
    ball = trimesh.creation.icosphere(subdivisions=5)
    for z_m in (-0.9, -0.2, 0.0, 0.5):
        cap_m3 = np.pi * (1.0 + z_m) ** 2 * (2.0 - z_m) / 3.0
        assert volume_below_m3(ball.triangles, z_m) == pytest.approx(cap_m3, rel=0.01)
    box = trimesh.creation.box((2.0, 1.0, 1.0))
    assert [volume_below_m3(box.triangles, z_m) for z_m in (-1.0, 0.1, 9.0)] == pytest.approx([0.0, 1.2, 2.0])


def test_a_boat_s_height_is_where_its_simulator_floats_it(otter: VehicleModel, tmp_path: Path) -> None:
    assert not any(is_boat(load_vehicle(name), SEA_KG_M3) for name in ("bluerov2_heavy", "slocum", "remus100"))
    sim = Simulator(in_deep_water(otter, SEA_KG_M3, tmp_path))
    assert floating_height_m(otter, SEA_KG_M3) == pytest.approx(-afloat(sim).water_z_m, abs=1e-4)


def test_a_boat_s_own_model_is_right_beside_its_log_without_depth(otter: VehicleModel, tmp_path: Path) -> None:
    found = fly_beside(log_of(otter, tmp_path, 200), otter, density_kg_m3=SEA_KG_M3, horizons_s=(1.0, 5.0))
    own, simplest = found.horizons[5.0], found.integrator[5.0]
    assert own["depth"] is own["tilt"] is None
    assert own["place"] and own["heading"] and own["speed"] and simplest["place"]
    assert own["place"].value < 0.05 and own["heading"].value < 1.0 and own["speed"].value < 0.02
    assert simplest["place"].value > 1.0
    assert any("the calm surface of 1025 kg/m3" in note.text for note in found.notes)


def test_a_boat_s_drag_is_identified_from_its_log(otter: VehicleModel, tmp_path: Path) -> None:
    log = log_of(otter, tmp_path, 40)
    wrong = otter.model_copy(update={"linear_damping": (120.0, *otter.linear_damping[1:])})
    groups = "mass_kg added_mass quadratic_damping centre_of_mass_m thrust_gain thrust_lag current_m_s command_delay"
    known = (*groups.split(), *(f"linear_damping.{axis}" for axis in ("sway", "heave", "roll", "pitch", "yaw")))
    result = identify(log, wrong, known=known, density_kg_m3=SEA_KG_M3)
    is_measured = np.isfinite(result.residuals).any(axis=0)
    assert is_measured.tolist() == [True, True, *[False] * 3, True, True, True, *[False] * 3, True]
    found = result.values["linear_damping.surge"]
    assert found.value == pytest.approx(77.55, abs=0.5) and found.is_determined


def test_a_log_of_another_kind_is_named_as_what_it_is(tmp_path: Path) -> None:
    (tmp_path / "a.ulg").write_bytes(b"ULog\x01\x12\x35\x01" + bytes(64))
    with pytest.raises(ValueError, match=r"a\.ulg: is a ULog of PX4 \(ulog2csv reads it\), which is not read"):
        read_flight(tmp_path / "a.ulg", COLUMNS)
