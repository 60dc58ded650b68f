"""Trials that others could have run: what the packaged vehicles, a cable and two sonars do in them."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.evidence.validate.flights import START_M, deep_scenario, deep_water
from uwsim.evidence.validate.reality.glides import GRAVITY_M_S2, WATER_KG_M3, simulated_glides
from uwsim.evidence.validate.sonars.table import Cell
from uwsim.evidence.vehicle.trials import TurningCircle, trial_m, turning_circles
from uwsim.scenario import Scenario, VehicleModel, load_vehicle
from uwsim.scenario.read.validated import validated
from uwsim.simulator.simulator import Simulator

SEA_KG_M3 = 1025.0
SAMPLE_S = 0.05
BATTERY_MM = 50.0  # of travel either way: assets/thrusters/slocum_battery.yaml
RUDDER_RAD, TURN_AT_RAD = math.radians(10.0), math.radians(10.0)
PIPE_M, PIPE_RADIUS_M = 5.0, 0.15


def _bare(name: str) -> VehicleModel:
    return load_vehicle(name).model_copy(update={"sensors": {}, "sonar": None, "imaging_sonars": {}})


def battery_pitch_deg_mm() -> float:
    """Return how far a sinking Slocum pitches for each millimetre that its battery moves, about 26 degrees [deg/mm]."""
    pitch_deg = []
    for battery in (-0.1, -0.3):
        sim = deep_water(_bare("slocum"), density_kg_m3=SEA_KG_M3, step_s=0.02)
        sim.rov.set_thrusters({"pump": -1.0, "battery": battery})
        sim.advance(200.0)
        pitch_deg.append(math.degrees(math.asin(sim.rov.pose.world_from_body[2, 0])))
    return (pitch_deg[0] - pitch_deg[1]) / (0.2 * BATTERY_MM)


@cache
def circle(name: str, surge: float) -> TurningCircle:
    """Return a vehicle's turning circle at full yaw, in the sea."""
    return turning_circles(deep_scenario(_bare(name), density_kg_m3=SEA_KG_M3), (surge,))[0]


def zigzag_overshoot_deg() -> float:
    """Return the first overshoot of the heading of a REMUS 100 in a zig-zag 10/10 at full surge, uncontrolled."""
    sim = deep_water(_bare("remus100"), density_kg_m3=SEA_KG_M3)
    rov = sim.rov
    rov.set_effort(surge=1.0)
    sim.advance(30.0)
    start = Rotation.from_matrix(rov.pose.world_from_body[:3, :3]).as_euler("ZYX")[0]
    share, largest, turned = 10.0 / 15.0, 0.0, False  # of the fins' 15 degrees
    rov.set_effort(surge=1.0, yaw=share)
    for _ in range(round(60.0 / SAMPLE_S)):
        sim.advance(SAMPLE_S)
        heading = float(Rotation.from_matrix(rov.pose.world_from_body[:3, :3]).as_euler("ZYX")[0]) - start
        if not turned and heading >= TURN_AT_RAD:
            rov.set_effort(surge=1.0, yaw=-share)
            turned = True
        if turned and heading < largest:
            break
        largest = max(largest, heading)
    return math.degrees(largest - TURN_AT_RAD)


@cache
def yaw_step() -> tuple[float, float]:
    """Return the yaw rate [deg/s] that a BlueROV2 Heavy reaches at half yaw effort, and the time to 63 % of it [s]."""
    sim = deep_water(_bare("bluerov2_heavy"), density_kg_m3=SEA_KG_M3)
    sim.rov.set_effort(yaw=0.5)
    rates = []
    for _ in range(round(15.0 / SAMPLE_S)):
        sim.advance(SAMPLE_S)
        rates.append(float(sim.rov.velocity.angular_body_rad_s[2]))
    return math.degrees(rates[-1]), SAMPLE_S * (1 + int(np.argmax(np.array(rates) >= 0.632 * rates[-1])))


def stopping_m(from_m_s: float = 2.0, to_m_s: float = 0.2) -> float:
    """Return how far an Otter goes from one speed to another with its propellers stopped."""
    sim = deep_water(_bare("otter"), density_kg_m3=SEA_KG_M3)
    sim.rov.place((0.0, 0.0, trial_m(sim, START_M[2])), velocity_body=(from_m_s, 0.0, 0.0, 0.0, 0.0, 0.0))
    while sim.rov.velocity.linear_body_m_s[0] > to_m_s and sim.time_s < 120.0:
        sim.advance(SAMPLE_S)
    return float(sim.rov.pose.position_world_m[0])


def trailing_angle_deg(diameter_m: float = 0.008, mass_kg_m: float = 0.25, speed_m_s: float = 2.0) -> float:
    """Return the angle below the horizontal of a wire rope that is towed without a load, with the default drag."""
    world = _core.World()
    world.set_terrain(np.full((2, 2), -200.0, np.float32), 800.0, (-400.0, -400.0))
    world.water = _core.Water()
    world.water.current_world_m_s = (speed_m_s, 0.0, 0.0)
    spec = _core.SimulationSpec()
    spec.step_s = 0.02
    simulation = _core.Simulation(world, _core.RayScene(world), spec)
    rope = _core.TetherSpec()
    rope.first, rope.second = _core.TetherEnd((0.0, 0.0, -20.0)), _core.TetherEnd((18.0, 0.0, -28.0))
    rope.length_m, rope.elements, rope.diameter_m, rope.mass_kg_m = 20.0, 20, diameter_m, mass_kg_m
    rope.axial_stiffness_n, rope.bending_stiffness_n_m2 = 1e6, 0.0
    simulation.add_tether(rope)
    simulation.cut_tether(0, 20.0)
    simulation.step(3000)
    x, _, z = np.diff(np.array(simulation.tether(0).points_world_m)[9:12:2], axis=0)[0]
    return math.degrees(math.atan2(-z, x))


def swath_over_depth(depth_m: float = 200.0) -> float:
    """Return the swath of an EM 2040-07 at 300 kHz over rock in the cold ocean, in depths."""
    return Cell("em2040-07", 300, "ocean").swath_m(depth_m) / depth_m


def pipe_width_deg() -> float:
    """Return how wide an upright pipe is in a Ping360's picture: what is within 6 dB of its brightest sample."""
    pipe = {
        "kind": "cylinder",
        "name": "pipe",
        "position_m": [PIPE_M, 0, -10],
        "radius_m": PIPE_RADIUS_M,
        "length_m": 16,
    }
    values = {
        "name": "pipe",
        "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 10, "bed_depth_m": 40, "hill_height_m": 0},
        "obstacles": [pipe | {"radius_m": PIPE_RADIUS_M}],
        "vehicles": [{"name": "rov", "model": "bluerov2_heavy_outfit", "start": {"position_m": [-0.1, 0, -10]}}],
    }
    with Simulator(validated(Scenario, values)) as sim:
        picture = sim.rov.imaging_sonars["scanning"].ping()
    near = abs(picture.model.bin_centres_m - PIPE_M + PIPE_RADIUS_M) < 0.5
    brightest = np.asarray(picture.level_db, np.float64)[near].max(axis=0)
    return 360.0 / len(brightest) * float((brightest >= brightest.max() - 6.0).sum())


def thrust_share_under_way(speed_m_s: float = 1.0, pwm_us: float = 1900.0) -> float:
    """Return the thrust of a T200 at 16 V that moves along its axis, as a share of that at rest."""
    sim = deep_water(_bare("bluerov2_wu"))
    found = []
    for speed in (0.0, speed_m_s):
        sim.rov.set_thrusters(dict.fromkeys(("vertical_left", "vertical_right"), (pwm_us - 1500.0) / 400.0))
        for _ in range(100):
            sim.rov.place(START_M, velocity_body=(0.0, 0.0, speed, 0.0, 0.0, 0.0))
            sim.advance(0.01)
        found.append(float(sim.rov.forces["actuators"].force_body_n[2]))
    return found[1] / found[0]


def glide_m_s(pitch_deg: float = 24.0, pumped_cm3: float = 230.0) -> float:
    """Return the root mean square of a Slocum's vertical speeds down and up, in which its ballast cancels."""
    pitches_rad, sinking_m_s, full_n = simulated_glides(load_vehicle("slocum"))
    net_n = 1e-6 * pumped_cm3 * WATER_KG_M3 * GRAVITY_M_S2
    return math.sqrt(net_n / full_n) * float(np.interp(math.radians(pitch_deg), pitches_rad, sinking_m_s))
