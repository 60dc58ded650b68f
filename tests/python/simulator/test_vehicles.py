"""The packaged vehicles have the published parameters and move accordingly."""

import ctypes
import platform
from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.optimize import brentq

from sea import open_water
from uwsim.scenario import ScenarioError, load_vehicle, rigid_body, vehicle_hull
from uwsim.scenario.read.assets import assets_folder, packaged_names

BLUEROVS = ("bluerov2_heavy", "bluerov2_heavy_cfd", "bluerov2_wu", "bluerov2_tank")
KINDS = ("rov", "bluerov2_heavy", "bluerov2_heavy_alpha5", "remus100", "slocum", "otter")
"""A vehicle of each kind of drive: forces, thrusters, an arm, fins, a pump, and propellers at the surface."""
FE_UNDERFLOW = {"x86_64": 0x10, "aarch64": 0x08}[platform.machine()]
T200 = {"diameter_m": 0.076, "kt": 0.445, "j0": 0.976}


def heavy_with(folder: Path, old: str, new: str) -> Path:
    """Write the BlueROV2 Heavy's file with one of its texts replaced; "added_mass" means that whole line."""
    text = (assets_folder() / "vehicles" / "bluerov2_heavy.yaml").read_text()
    if old == "added_mass":
        old = next(line for line in text.splitlines() if line.startswith("added_mass:"))
    assert old in text
    path = folder / "changed.yaml"
    path.write_text(text.replace(old, new, 1))
    return path


def hull(name: str) -> trimesh.Trimesh:
    return trimesh.Trimesh(*vehicle_hull(load_vehicle(name)), process=False)


@pytest.mark.parametrize("name", packaged_names("vehicles"))
def test_a_hull_is_closed_in_one_piece_and_has_the_published_volume(name: str) -> None:
    model, mesh = load_vehicle(name), hull(name)
    assert mesh.is_watertight
    assert len(mesh.split()) == 1
    assert len(mesh.faces) <= 3000
    if model.volume_m3 is not None:
        assert mesh.volume == pytest.approx(model.volume_m3, rel=1e-12)
    if model.centre_of_buoyancy_m is not None:
        np.testing.assert_allclose(mesh.center_mass, model.centre_of_buoyancy_m, atol=1e-12)


@pytest.mark.parametrize(
    ("name", "size_m"),
    [
        ("bluerov2_heavy", (0.4571, 0.575, 0.2539)),
        ("bluerov2_wu", (0.4571, 0.338, 0.2539)),
        ("bluerov2_tank", (0.4571, 0.338, 0.2539)),
        ("remus100", (1.6, None, None)),
    ],
)
def test_a_mesh_has_the_published_size(name: str, size_m: tuple[float | None, ...]) -> None:
    for extent, published in zip(hull(name).extents, size_m, strict=True):
        if published is not None:
            assert extent == pytest.approx(published, rel=0.07)


def test_remus_has_the_mass_properties_of_its_spheroid() -> None:
    a, b = 0.8, 0.095
    body = rigid_body(load_vehicle("remus100"), 1026.0)
    assert body.volume_m3 == pytest.approx(4 / 3 * np.pi * a * b**2, rel=1e-4)
    assert body.mass_kg == pytest.approx(31.03, rel=1e-3)
    np.testing.assert_allclose(body.inertia_kg_m2[1], body.mass_kg / 5 * (a**2 + b**2), rtol=1e-3)


@pytest.mark.parametrize("name", KINDS)
def test_no_number_of_a_vehicle_at_rest_becomes_subnormal(name: str, tmp_path: Path) -> None:
    """A step with subnormal numbers takes up to three times as long; they arise from decays that never reach zero."""
    sim = open_water(tmp_path, name)
    rov = sim.rov
    axes = [axis for axis in ("surge", "sway", "heave", "roll", "pitch", "yaw") if axis in rov.controllable]
    rov.set_effort(**dict.fromkeys(axes, 0.3))
    sim.advance(2.0)
    rov.set_effort(**dict.fromkeys(axes, 0.0))
    sim.advance(300.0)
    libm = ctypes.CDLL("libm.so.6")
    libm.feclearexcept(FE_UNDERFLOW)
    sim.step(200)
    assert not libm.fetestexcept(FE_UNDERFLOW)


def test_a_submerged_vehicle_has_its_published_weight(tmp_path: Path) -> None:
    """Released at rest in fresh water, a BlueROV2 Heavy sinks as its mass, volume and added mass predict."""
    sim = open_water(tmp_path, "bluerov2_heavy", density_kg_m3=1000.0)
    sim.step(2)
    acceleration = sim.rov.velocity.linear_body_m_s[2] / (2 * sim.step_s)
    assert acceleration == pytest.approx((0.0134 * 1000 - 13.5) * 9.80665 / (13.5 + 18.6863), rel=0.02)


def bollard(name: str, axis: int) -> list[tuple[float, float, float]]:
    """Return (thrust, its component along the axis, thruster count) at full effort ahead, from the frame geometry."""
    cos45 = np.sqrt(0.5)
    if axis == 0:
        return [(51.5, cos45, 2), (39.9, cos45, 2)]
    return [(51.5, 1.0, 4 if name.startswith("bluerov2_heavy") else 2)]


def thrust_n(name: str, axis: int, speed_m_s: float, density_kg_m3: float) -> float:
    """Return the total thrust along the axis at this speed, by the bilinear model."""
    total = 0.0
    for full_n, share, count in bollard(name, axis):
        turns_s = np.sqrt(full_n / (density_kg_m3 * T200["kt"] * T200["diameter_m"] ** 4))
        lost = full_n * share * speed_m_s / (T200["j0"] * turns_s * T200["diameter_m"])
        total += count * share * (full_n - lost)
    return total


@pytest.mark.parametrize("name", BLUEROVS)
@pytest.mark.parametrize(("effort", "axis"), [("surge", 0), ("heave", 2)])
def test_the_terminal_speed_follows_from_drag_and_thrust(tmp_path: Path, name: str, effort: str, axis: int) -> None:
    model = load_vehicle(name)
    assert model.linear_damping is not None and model.quadratic_damping is not None
    linear, quadratic = model.linear_damping[axis], model.quadratic_damping[axis]
    density = model.mass_kg / model.volume_m3  # neutral, to prevent drift
    expected = brentq(lambda u: thrust_n(name, axis, u, density) - linear * u - quadratic * u * u, 0, 10)
    sim = open_water(tmp_path, name, density_kg_m3=density)
    sim.rov.place((0, 0, -30), velocity_body=0.9 * expected * np.eye(6)[axis])
    sim.rov.set_effort(**{effort: 1.0})
    sim.advance(2.0)
    assert sim.rov.velocity.linear_body_m_s[axis] == pytest.approx(expected, rel=2e-3)


def test_the_standard_frame_cannot_pitch(tmp_path: Path) -> None:
    rov = open_water(tmp_path, "bluerov2_wu").rov
    assert rov.controllable == {"surge", "sway", "heave", "roll", "yaw"}
    rov.set_effort(pitch=1.0)
    assert all(thruster.command == 0 for thruster in rov.thrusters.values())


def steady_turn(folder: Path, rudder_deg: float) -> tuple[float, float]:
    """Return REMUS's (speed, yaw rate) in a steady turn at full propeller speed."""
    sim = open_water(folder, "remus100", density_kg_m3=1026.0)
    sim.rov.set_effort(surge=1.0)
    sim.advance(10.0)
    sim.rov.set_fins({"top": np.radians(rudder_deg), "bottom": -np.radians(rudder_deg)})
    sim.advance(20.0)
    return sim.rov.telemetry().speed_m_s, float(sim.rov.velocity.angular_body_rad_s[2])


def test_remus_runs_at_its_published_speed_and_turns_with_its_rudder(tmp_path: Path) -> None:
    """2.5 m/s at 1525 rpm (PythonVehicleSimulator); more rudder turns tighter, equally to both sides."""
    straight_m_s, straight_rad_s = steady_turn(tmp_path, 0)
    assert straight_m_s == pytest.approx(2.5, rel=0.03)
    assert abs(straight_rad_s) < 1e-4, "the vehicle holds its course"
    slight, hard = steady_turn(tmp_path, 5), steady_turn(tmp_path, 10)
    assert slight[1] < -0.1 and hard[1] < 1.5 * slight[1]
    assert 5 < slight[0] / -slight[1] < 15, "the turn's radius is some lengths"
    assert hard[0] < slight[0] < straight_m_s
    other = steady_turn(tmp_path, -5)
    assert other[1] == pytest.approx(-slight[1], rel=0.02)


def test_a_mesh_far_from_the_published_volume_is_refused(tmp_path: Path) -> None:
    path = heavy_with(tmp_path, "volume_m3: 0.0134", "volume_m3: 0.05")
    with pytest.raises(ScenarioError, match=r"encloses 0\.01\d* m3, volume_m3 = 0\.05 m3: .*must be within 10%"):
        vehicle_hull(load_vehicle(path))


OUTSIDE = r"centre_of_mass_m = \(.*\) m: must be in the hull's bounding box"
IDENTITY = np.eye(6, dtype=int).tolist()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("centre_of_mass_m: [0.0, 0.0, 0.0]", "centre_of_mass_m: [0.0, 0.0, -0.5]", OUTSIDE),
        ("centre_of_buoyancy_m: [0.0, 0.0, 0.01]", "centre_of_buoyancy_m: [0.0, 3.0, 0.0]", OUTSIDE),
        ("mass_kg: 13.5", "mass_kg: -13.5", r"mass_kg = -13\.5 kg: must be in"),
        ("axis: [-1, 1, 0]", "axis: [0, 0, 0]", r"thrusters\.front_left\.axis = \[.*\]: must not have zero length"),
        ("model: t200_16v", "model: t200_61v", r"unknown thruster 't200_61v'.*did you mean 't200_16v'"),
        ("mass_kg: 13.5", "mass_kg: 13.5\nmax_force_n: [1, 1, 1]", r"max_force_n: must not be given"),
        ("linear_damping: [13.7, 0.0, 33.0, 0.0, 0.8, 0.0]", "# none", r"linear_damping: missing"),
        ("added_mass:", f"added_mass_matrix: {IDENTITY}\nadded_mass:", "_matrix: must not be given beside added_mass"),
    ],
)
def test_invalid_values_are_refused_in_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as raised:
        rigid_body(load_vehicle(heavy_with(tmp_path, old, new)), 1000.0)
    assert "\n" not in str(raised.value)


def test_a_full_matrix_may_replace_a_diagonal(tmp_path: Path) -> None:
    matrix = np.diag([6.3567, 7.1206, 18.6863, 0.1858, 0.1348, 0.2215])
    matrix[0, 4] = matrix[4, 0] = 0.3
    path = heavy_with(tmp_path, "added_mass", f"added_mass_matrix: {matrix.tolist()}")
    np.testing.assert_array_equal(load_vehicle(path).matrix("added_mass"), matrix)
    sim = open_water(tmp_path, str(path), density_kg_m3=13.5 / 0.0134)
    sim.rov.set_wrench([10.0, 0.0, 0.0])
    sim.advance(0.1)
    assert sim.rov.velocity.angular_body_rad_s[1] < -1e-4, "surge is coupled to pitch"


def test_a_matrix_that_is_not_positive_semi_definite_is_refused_when_the_vehicle_is_built(tmp_path: Path) -> None:
    matrix = np.diag([6.3567, 7.1206, -18.6863, 0.1858, 0.1348, 0.2215])
    path = heavy_with(tmp_path, "added_mass", f"added_mass_matrix: {matrix.tolist()}")
    with pytest.raises(ValueError, match=r"added_mass = .*: must be positive semi-definite"):
        open_water(tmp_path, str(path))
