"""How a published number is asked of uwsim: one function for each kind of question, all on a simulator."""

from __future__ import annotations

import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from uwsim.batch import Batch
from uwsim.evidence.validate.flights import deep_water
from uwsim.scenario import load_vehicle
from uwsim.scenario.build.potential_flow import added_mass_of_mesh
from uwsim.scenario.dump import yaml_text
from uwsim.scenario.read.assets import assets_folder
from uwsim.scenario.read.thruster_sheets import read_sheet_rows
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.camera import CameraMount
from uwsim.scenario.spec.scenario import Scenario
from uwsim.simulator.simulator import Simulator

SETTLED_S, LOOK_S, NARROW_M = 60.0, 0.5, 0.05
BED_M, BED_SIZE_M = 250.0, 400.0
FRAMES, STEPS, ROUNDS = 5, 2000, 3


def terminal_speed(force_n: float, linear_n_s_m: float, quadratic_n_s2_m2: float) -> float:
    """Return the speed ahead [m/s] of a body on which a force acts for SETTLED_S, against its two drags."""
    damping = {"linear_damping": (linear_n_s_m,) * 6, "quadratic_damping": (quadratic_n_s2_m2,) * 6}
    model = load_vehicle("paper").model_copy(update={**damping, "max_force_n": (force_n,) * 3})
    sim = deep_water(model)
    sim.rov.set_effort(surge=1.0)
    sim.advance(SETTLED_S)
    return float(sim.rov.velocity.linear_body_m_s[0])


def sphere_added_mass(radius_m: float, density_kg_m3: float) -> float:
    """Return the added mass [kg] of a sphere along x, by panels on a mesh of it."""
    from uwsim.base.whole_trimesh import trimesh

    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius_m)
    return float(added_mass_of_mesh(np.asarray(mesh.vertices), np.asarray(mesh.faces), density_kg_m3)[0, 0])


def dvl_altitude(slant_deg: float, range_max_m: float) -> float:
    """Return the greatest altitude [m] with bottom lock over a level bed, by halving to within NARROW_M."""
    dvl = {"kind": "dvl", "rate_hz": 5, "beam_slant_deg": slant_deg, "range_max_m": range_max_m}
    sim = _over_a_bed({"sensors": {"dvl": dvl}})
    low_m, high_m = 1.0, 2.0 * range_max_m
    while high_m - low_m > NARROW_M:
        middle_m = 0.5 * (low_m + high_m)
        sim.rov.place([0.0, 0.0, middle_m - BED_M])
        sim.advance(LOOK_S)
        low_m, high_m = (middle_m, high_m) if sim.rov.sensors["dvl"].sample().valid else (low_m, middle_m)
    return low_m


def beams_on_wall(beams: int, field_of_view_deg: float, range_max_m: float, wall_m: float) -> float:
    """Return the number of a level multibeam's beams whose range is that of a wall ahead, wall_m / cos(angle)."""
    sonar = {
        "name": "asked", "beams": beams, "ping_rate_max_hz": 10, "tilt_rate_deg_s": 30,
        "frequencies": [{"frequency_hz": 900_000, "field_of_view_deg": field_of_view_deg, "range_max_m": range_max_m}],
    }  # fmt: skip
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "asked.yaml"
        path.write_text(yaml_text(sonar))
        mount = load_vehicle("paper").sonar
        assert mount is not None
        ahead_m = wall_m + mount.position_m[0]
        wall = {"kind": "box", "name": "wall", "position_m": [ahead_m + 0.5, 0, -50], "size_m": [1, 100, 40]}
        sim = _over_a_bed({}, obstacles=[wall], sonar={"model": str(path), "tilt_deg": 0})
        sim.rov.place([0.0, 0.0, -50.0])
        ping = sim.rov.sonar.ping()
    wanted_m = wall_m / np.cos(np.asarray(ping.angles_rad, np.float64))
    return float(np.count_nonzero(np.abs(ping.ranges_m - wanted_m) < 1e-3 * wanted_m))


def pressure(depth_m: float, density_kg_m3: float) -> float:
    """Return the absolute pressure [Pa] that an ideal sensor measures at a depth."""
    sim = _over_a_bed({"sensors": {"pressure": {"kind": "pressure", "rate_hz": 20}}}, density_kg_m3=density_kg_m3)
    sim.rov.place([0.0, 0.0, -depth_m])
    sim.advance(0.2)
    return float(sim.rov.sensors["pressure"].read())


def t200_thrust(rpm: float, voltage_v: float) -> float:
    """Return the thrust [N] of the packaged T200 at a rate of turn ahead, by the square of the rate in its sheet."""
    sheet = [row for row in read_sheet_rows(assets_folder() / "thrusters/t200_10v_20v.csv") if row.command > 1500.0]
    ahead = sorted((row.rpm, row.thrust_n) for row in sheet if row.voltage_v == voltage_v)
    turns, thrusts = np.array(ahead).T
    return float(np.interp(rpm**2, turns**2, thrusts))


def frame_time_ratio(small_pixels: int, large_pixels: int) -> float:
    """Return the time of a picture with the larger side relative to one with the smaller, square, of the lake."""
    times = []
    for pixels in (small_pixels, large_pixels):
        model = load_vehicle("rov")
        mount = CameraMount(position_m=(0.7, 0.0, 0.0), width=pixels, height=pixels, field_of_view_deg=90)
        scenario = Simulator("lake").scenario.with_changes(
            vehicle_model=model.model_copy(update={"cameras": {"asked": mount}})
        )
        sim = Simulator(scenario)
        sim.rov.place((-67.0, -52.0, -24.0))
        times.append(median(_seconds(sim.rov.cameras["asked"].capture) for _ in range(FRAMES)))
    return times[1] / times[0]


def steps_per_second(scenario: str, members: int) -> float:
    """Return the vehicle steps per second of a batch on all processors, the median of ROUNDS."""
    batch = Batch(scenario, n=members)
    return members * STEPS / median(_seconds(lambda: batch.step(STEPS)) for _ in range(ROUNDS))


def _seconds(work: Callable[[], object]) -> float:
    began_s = time.perf_counter()
    work()
    return time.perf_counter() - began_s


def _over_a_bed(
    vehicle: dict[str, Any], *, density_kg_m3: float = 1000.0, obstacles: Any = (), sonar: Any = None
) -> Simulator:
    """Return a simulator of the vehicle `paper`, with changes, over a level bed at BED_M."""
    model = load_vehicle("paper")
    changed = validated(type(model), {**model.given(), **vehicle})
    entry = {"name": "rov", "model": changed, "start": {"position_m": [0, 0, -20]}}
    return Simulator(
        validated(
            Scenario,
            {
                "name": "claims",
                "water": {"density_kg_m3": density_kg_m3},
                "terrain": {"source": "noise", "size_m": [BED_SIZE_M] * 2, "spacing_m": 10, "bed_depth_m": BED_M},
                "station": {"position_m": [0, 0, 0]},
                "vehicles": [entry if sonar is None else {**entry, "sonar": sonar}],
                "obstacles": list(obstacles),
            },
        )
    )


ASKS: dict[str, Callable[..., float]] = {
    each.__name__: each
    for each in (
        terminal_speed, sphere_added_mass, dvl_altitude, beams_on_wall, pressure, t200_thrust, frame_time_ratio,
        steps_per_second,
    )
}  # fmt: skip
"""The kinds of questions by name. Each has its parameters as keywords, and returns the number in the claim's unit."""


def asked(kind: str, **arguments: Any) -> float:
    """Return uwsim's number, or nan if it has none."""
    found = ASKS[kind](**arguments)
    return found if math.isfinite(found) else math.nan
