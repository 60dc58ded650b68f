"""The cross-check's adapter for uwsim: reads the cases beside it, computes each quantity, and prints a table.

    python docs/cross-check/run_uwsim.py            # exits with 1 if a case misses its tolerance

An adapter is a function per case that returns the quantity named under `expect`; None: the simulator has no such model.
"""

from __future__ import annotations

import math
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from ruamel.yaml import YAML

from uwsim import Simulator, _core
from uwsim.evidence.validate.camera import Light, wall_at
from uwsim.evidence.validate.flights import BED_DEPTH_M
from uwsim.evidence.validate.motion.closed_forms import simulator_with_body
from uwsim.evidence.validate.motion.reference_solution import Coefficients
from uwsim.instruments.acoustics import arrivals
from uwsim.scenario import Scenario

Case = dict[str, Any]
CASES = Path(__file__).parent / "cases"


def load(path: Path) -> Case:
    """Return a case."""
    return dict(YAML(typ="safe", pure=True).load(path.read_text(encoding="utf-8")))


def error(case: Case, got: float) -> float:
    """Return the error, relative to the expected value unless that is zero."""
    expected = case["expect"]["value"]
    return abs(got - expected) / (abs(expected) or 1.0)


def _mesh(body: Case) -> trimesh.Trimesh:
    if body["shape"] == "box":
        return trimesh.creation.box(body["size_m"])
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=1.0)
    mesh.apply_scale(body.get("semi_axes_m", [body.get("radius_m")] * 3))
    return mesh


def _simulator(case: Case) -> tuple[Simulator, Coefficients]:
    """Return a simulator of the body alone; a mesh has the volume of the shape only nearly, so drag uses the mesh's."""
    body, rho = case["body"], case["water"]["density_kg_m3"]
    mesh = _mesh(body)
    mass = body["density_kg_m3"] * mesh.volume
    if body["shape"] == "box":
        x, y, z = body["size_m"]
        inertia = (mass / 12 * (y * y + z * z), mass / 12 * (x * x + z * z), mass / 12 * (x * x + y * y))
    else:
        inertia = (0.4 * mass * body.get("radius_m", 0.0) ** 2,) * 3
    along = body.get("added_mass_coefficient", 0.0) * rho * mesh.volume
    drag = 0.0
    if body["drag_coefficient"]:
        share = mesh.volume / (4 / 3 * math.pi * body["radius_m"] ** 3)
        drag = share * 0.5 * rho * body["drag_coefficient"] * math.pi * body["radius_m"] ** 2
    coefficients = Coefficients(
        mass_kg=mass,
        volume_m3=mesh.volume,
        inertia_kg_m2=tuple(body.get("inertia_kg_m2", inertia)),
        added_mass=tuple(body.get("added_mass", (along,) * 3 + (0.0,) * 3)),
        linear_damping=(0.0,) * 6,
        quadratic_damping=(drag,) * 3 + (0.0,) * 3,
        centre_of_mass_m=(0.0, 0.0, -body.get("centre_of_mass_below_centre_m", 0.0)),
        water_density_kg_m3=rho,
    )
    contact = {"friction": body.get("friction", 0.5), "restitution": body.get("restitution", 0.0)}
    return simulator_with_body(coefficients, mesh, **contact), coefficients


def _velocity(sim: Simulator) -> np.ndarray:
    velocity = sim.rov.velocity
    return np.concatenate([velocity.linear_body_m_s, velocity.angular_body_rad_s])


def terminal_speed(case: Case) -> float:
    """Return the speed of a sphere that sinks from rest."""
    sim, _ = _simulator(case)
    sim.rov.place((0, 0, -400))
    sim.advance(case["run_s"])
    return float(-_velocity(sim)[2])


def heave_period(case: Case) -> float:
    """Return the mean time between upward passages of the floating position."""
    sim, _ = _simulator(case)
    height_m = case["body"]["size_m"][2]
    level_m = height_m / 2 - height_m * case["body"]["density_kg_m3"] / case["water"]["density_kg_m3"]
    sim.rov.place((0, 0, level_m + 0.05))
    heights = []
    for _ in range(round(case["run_s"] / sim.step_s)):
        heights.append(sim.rov.pose.position_world_m[2] - level_m)
        sim.step()
    z = np.array(heights)
    up = np.flatnonzero((z[:-1] < 0) & (z[1:] >= 0))
    passes = up - z[up] / (z[up + 1] - z[up])
    return float(np.diff(passes).mean() * sim.step_s)


def munk_moment(case: Case) -> float:
    """Return the mean yaw acceleration over a few steps."""
    sim, _ = _simulator(case)
    sim.rov.place((0, 0, -400), velocity_body=[*case["start"]["velocity_body_m_s"], *case["start"]["rates_body_rad_s"]])
    sim.advance(case["run_s"])
    return float(_velocity(sim)[5] / case["run_s"])


def kirchhoff_ellipsoid(case: Case) -> float:
    """Return the largest relative change of energy and impulse."""
    sim, body = _simulator(case)
    sim.rov.place((0, 0, -400), velocity_body=[*case["start"]["velocity_body_m_s"], *case["start"]["rates_body_rad_s"]])
    kept = []
    for _ in range(round(case["run_s"] / 0.1) + 1):
        nu = _velocity(sim)
        kept.append((0.5 * nu @ body.mass @ nu, np.linalg.norm((body.mass @ nu)[:3])))
        sim.advance(0.1)
    return float(np.abs(np.array(kept) / kept[0] - 1).max())


def sphere_added_mass(case: Case) -> float:
    """Return the acceleration over the first step."""
    sim, _ = _simulator(case)
    sim.rov.place((0, 0, -400))
    sim.step()
    return float(-_velocity(sim)[2] / sim.step_s)


def bounce(case: Case) -> float:
    """Return the speed after the contact with the bed."""
    sim, _ = _simulator(case)
    lift_m = case["body"]["size_m"][2] / 2 + case["start"]["height_of_the_lower_face_m"]
    sim.rov.place((0, 0, -BED_DEPTH_M + lift_m), velocity_body=[*case["start"]["velocity_m_s"], 0, 0, 0])
    sim.advance(case["run_s"])
    return float(_velocity(sim)[2])


def incline(case: Case) -> float:
    """Return how far a box slides down a tilted box."""
    sim, _ = _simulator(case)
    tilt = math.radians(case["incline_deg"])
    normal = np.array([math.sin(tilt), 0.0, math.cos(tilt)])
    centre = np.array([0.0, 0.0, -500.0])
    slope = {
        "kind": "box", "name": "slope", "position_m": centre.tolist(), "size_m": [20.0, 20.0, 1.0],
        "yaw_pitch_roll_deg": [0.0, case["incline_deg"], 0.0],
    }  # fmt: skip
    (entry,) = sim.scenario.vehicles
    with tempfile.TemporaryDirectory() as folder:
        hull = Path(folder) / "hull.obj"
        _mesh(case["body"]).export(hull)
        moved = entry.model_copy(update={"model": entry.model.model_copy(update={"mesh": hull})})
        given = {**sim.scenario.given(), "obstacles": [slope], "vehicles": [moved]}
        sim = Simulator(Scenario.model_validate(given))
    half = (0.0, math.sin(tilt / 2), 0.0, math.cos(tilt / 2))
    start = centre + (0.5 + case["body"]["size_m"][2] / 2) * normal
    sim.rov.place(start, half)
    sim.advance(case["run_s"])
    return float((sim.rov.pose.position_world_m - start) @ [math.cos(tilt), 0.0, -math.sin(tilt)])


def ray_to_plane(case: Case) -> float:
    """Return the range of a ray to the bed."""
    world = _core.World()
    world.set_terrain(np.full((3, 3), -100.0, np.float32), 100.0, (-100.0, -100.0))
    below = math.radians(case["beam_below_horizontal_deg"])
    hits = _core.RayScene(world).cast(
        [[0.0, 0.0, -100.0 + case["height_above_bed_m"]]], [[math.cos(below), 0.0, -math.sin(below)]], 100.0
    )
    return float(hits.ranges_m[0])


def echo_level(case: Case) -> float:
    """Return the echo's level from the one-way loss of the direct path, there and back."""
    water, target = case["water"], case["target"]
    speed = water["sound_speed_m_s"]
    found = arrivals(
        [(0, speed), (water["depth_m"], speed)], target["depth_m"], target["depth_m"], target["range_m"],
        absorption_db_km=water["absorption_db_km"],
    )  # fmt: skip
    return float(case["source_level_db"] + 2 * found.level_db[np.argmin(found.time_s)] + target["strength_db"])


def beer_lambert(case: Case) -> float:
    """Return the share of a wall's light that is left, from two pictures of it."""
    a, b = case["water"]["absorption_1_m"], case["water"]["scattering_1_m"]

    class GivenWater(Light):
        @property
        def water(self) -> _core.WaterOptics:
            return _core.WaterOptics([a] * 3, [a] * 3, [b] * 3)

    view = wall_at(case["range_m"])
    return float(
        np.mean(view.ahead(GivenWater(), ["sunlight", "attenuation"]) / view.ahead(GivenWater(), ["sunlight"]))
    )


def catenary(case: Case) -> float:
    """Return the horizontal tension of a tether that is laid at rest between two points of one height."""
    chain, water = case["chain"], {"density_kg_m3": 1000.0}
    diameter_m, gravity_m_s2 = 0.01, 9.80665
    displaced_kg_m = water["density_kg_m3"] * math.pi * diameter_m**2 / 4
    tether = {
        "anchor": [0.0, 0.0, -5.0], "length_m": chain["length_m"], "elements": 100, "diameter_m": diameter_m,
        "mass_kg_m": chain["weight_in_water_n_m"] / gravity_m_s2 + displaced_kg_m,
        "axial_stiffness_n": 1e7, "bending_stiffness_n_m2": 0.0,
    }  # fmt: skip
    vehicle = {"name": "rov", "model": "bluerov2_heavy", "start": {"position_m": [chain["span_m"], 0.0, -5.0]}}
    bed = {"source": "noise", "size_m": [60, 60], "spacing_m": 1.0, "bed_depth_m": 50}
    sim = Simulator({"name": "chain", "water": water, "terrain": bed, "vehicles": [vehicle | {"tether": tether}]})
    laid = sim.rov.tether.read()
    along = np.diff(laid.points_world_m, axis=0)
    return float(np.mean(laid.tensions_n * along[:, 0] / np.linalg.norm(along, axis=1)))


def bent_ray_delay(case: Case) -> float:
    """Return the travel time of the first arrival."""
    ends = case["source_depth_m"], case["receiver_depth_m"], case["range_m"]
    found = arrivals(case["water"]["profile"], *ends)
    direct = (found.surface_bounces == 0) & (found.bottom_bounces == 0)
    return float(found.time_s[direct].min())


ADAPTER: dict[str, Callable[[Case], float | None]] = {
    "terminal-speed": terminal_speed, "heave-period": heave_period, "munk-moment": munk_moment,
    "kirchhoff-ellipsoid": kirchhoff_ellipsoid, "sphere-added-mass": sphere_added_mass, "bounce": bounce,
    "incline": incline, "ray-to-plane": ray_to_plane, "echo-level": echo_level, "beer-lambert": beer_lambert,
    "catenary": catenary, "bent-ray-delay": bent_ray_delay,
}  # fmt: skip


def main() -> int:
    """Print the table; return 1 if a case misses its tolerance."""
    missed = 0
    for path in sorted(CASES.glob("*.yaml")):
        case = load(path)
        got, expect = ADAPTER[path.stem.partition("-")[2]](case), case["expect"]
        if got is None:
            print(f"{path.stem:24} not modelled")  # noqa: T201
            continue
        off = error(case, got)
        missed += not off <= expect["tolerance"]
        verdict = "pass" if off <= expect["tolerance"] else "MISS"
        print(f"{path.stem:24} {expect['value']:14.9g} {got:14.9g} {expect['unit']:6} error {off:.1e} {verdict}")  # noqa: T201
    return min(missed, 1)


if __name__ == "__main__":
    sys.exit(main())
