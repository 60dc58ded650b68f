"""A scenario in which every parameter has an effect, and the observations that reveal it."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from uwsim import Simulator
from uwsim.scenario.spec.sonar import load_sonar

NOISE = {
    "std": 0.01, "density": 0.002, "turn_on_std": 0.02, "bias_std": 0.03, "bias_time_s": 0.5, "walk": 0.05,
    "instability": 0.004, "quantum": 0.001,
}  # fmt: skip
TIMES = {"rate_hz": 50, "latency_s": 0.02, "drop_out": 0.3}
SENSORS: dict[str, Any] = {
    "imu": {
        "kind": "imu",
        **TIMES,
        "channels": {"angular_velocity": NOISE | {"limits": [-0.2, 0.2]}, "linear_acceleration": NOISE},
        "noise": NOISE,
        "gyro_scale": [0.01, 0.02, 0.03],
        "gyro_misalignment_rad": [0.01] * 6,
        "gyro_g_sensitivity": [1e-4] * 9,
        "accelerometer_scale": [0.01, 0.02, 0.03],
        "accelerometer_misalignment_rad": [0.01] * 6,
    },
    "depth": {"kind": "depth", **TIMES, "noise": NOISE, "density_kg_m3": 990},
    "altitude": {"kind": "altitude", "noise": NOISE, "range_max_m": 20, "range_min_m": 0.1},
    "port": {
        "kind": "proximity",
        "yaw_pitch_roll_deg": [0, 80, 0],
        "range_max_m": 20,
        "range_min_m": 0.1,
        "noise": NOISE,
    },
    "dvl": {"kind": "dvl", "channels": {"beam_velocity": NOISE}, "noise": NOISE, "range_max_m": 20, "range_min_m": 0.1},
    "usbl": {"kind": "usbl", "channels": {"bearing": NOISE}, "noise": NOISE, "range_max_m": 50},
    "compass": {"kind": "compass", "noise": NOISE, "hard_iron_ut": [1, 2, 3]},
    "gyrocompass": {"kind": "gyrocompass", "noise": NOISE, "latitude_deg": 60},
    "contact": {"kind": "contact"},
    "ctd": {"kind": "ctd", **TIMES, "channels": {"temperature": NOISE}},
    "ins": {"kind": "ins", **TIMES, "grade": "mems", "noise": NOISE},
}
SIX = [30.0, 40.0, 50.0, 6.0, 7.0, 8.0]
HULL: dict[str, Any] = {
    "mesh": str(Path(__file__).with_name("box.obj")), "collision": "box", "centre_of_mass_m": [0, 0, 0],
    "inertia_kg_m2": [23, 39, 42],
    "centre_of_buoyancy_m": [0.01, 0.01, 0.1], "ballast_kg": 5, "ballast_position_m": [0.1, 0.1, -0.2],
    "sonar": {"position_m": [0.5, 0, -0.2]},
}  # fmt: skip
ROV = HULL | {
    "name": "rov", "mass_kg": 690, "added_mass": SIX, "linear_damping": SIX, "quadratic_damping": SIX,
    "max_force_n": [400, 300, 300], "max_torque_nm": [30, 40, 50], "sensors": SENSORS,
    "cameras": {"front": {"position_m": [0.6, 0, 0], "yaw_pitch_roll_deg": [0, 30, 0], "width": 24, "height": 16,
                          "wobble_mrad": 3}},
    "lamps": {"front": {"on": True, "flux_lm": 5000, "colour": [1, 0.9, 0.8],
                        "spots": [{"position_m": [0.6, 0.2, 0.1], "yaw_pitch_roll_deg": [0, 30, 0]}]}},
    "imaging_sonars": {
        "ahead": {"kind": "forward_looking", "yaw_pitch_roll_deg": [0, 20, 0], "range_max_m": 8, "range_bins": 20,
                  "beams": 4, "field_of_view_deg": 60, "rays_per_column": 8},
    },
}  # fmt: skip
PROPELLER = {
    "name": "propeller", "thrust_n": [[-1, -100], [0, 0], [1, 120]], "time_constant_s": 0.2, "diameter_m": 0.1,
    "zero_thrust_advance_ratio": 0.9, "torque_per_thrust_m": 0.05,
    "sheets": str(Path(__file__).with_name("propeller.csv")),
}  # fmt: skip
MATRIX = np.diag(SIX) + 0.5
AUV = HULL | {
    "name": "auv", "mass_kg": 700, "added_mass": SIX, "linear_damping_matrix": MATRIX.tolist(),
    "quadratic_damping": SIX,
    "thrusters": {
        "left": {"model": PROPELLER, "position_m": [-0.3, 0.2, 0], "axis": [1, 0, 0]},
        "right": {"model": PROPELLER, "position_m": [-0.3, -0.2, 0], "axis": [1, 0, 0]},
    },
    "fins": {"tail": {"position_m": [-0.5, 0, 0], "span": [0, 1, 0], "area_m2": 0.05, "aspect_ratio": 4.0,
                      "parasitic_drag": 0.02, "stall_angle_deg": 10, "deflection_max_deg": 20, "rate_max_deg_s": 5}},
    "imaging_sonars": {
        "aside": {"kind": "side_scan", "range_max_m": 8, "range_bins": 20, "planes": 4, "noise_level_db": 80},
        "below": {"kind": "single_beam", "yaw_pitch_roll_deg": [0, 90, 0], "range_max_m": 8, "range_bins": 20},
    },
}  # fmt: skip
BATTERY = {
    "hotel_w": 50,
    "model": {"name": "small", "capacity_ah": 0.05, "open_circuit_v": [[0, 12], [1, 16]], "resistance_ohm": 0.05,
              "cutoff_v": 11},
}  # fmt: skip
MULTIBEAM = load_sonar("em2040-07")
SONAR = {"frequency_hz": 400000, "tilt_deg": 40, "range_max_m": 30}
WORLD: dict[str, Any] = {
    "name": "every_parameter",
    "seed": 3,
    "mission_time_s": 1,
    "water": {
        "density_kg_m3": 1020, "surface_temperature_deg_c": 15, "bottom_temperature_deg_c": 8, "salinity_psu": 20,
        "current_world_m_s": [0.3, 0.1, 0.05],
        "surface": {"kind": "airy", "amplitude_m": 0.3, "period_s": 3, "heading_deg": 20, "phase_deg": 30,
                    "depth_m": 5},
        "current": [
            {"kind": "uniform", "velocity_m_s": [0.1, 0.1, 0]},
            {"kind": "layers", "levels": [{"depth_m": 0, "velocity_m_s": [0.2, 0, 0]},
                                          {"depth_m": 5, "velocity_m_s": [0, 0.1, 0]}]},
            {"kind": "tidal", "amplitude_m_s": [0.1, 0.2, 0], "period_s": 60, "phase_deg": 10},
            {"kind": "gusts", "mean_m_s": [0.1, 0, 0], "sigma_m_s": [0.1, 0.1, 0.1], "correlation_time_s": 1},
        ],
    },
    "optics": {"wind_m_s": 4, "particles_per_m3": 30},
    "terrain": {"source": "noise", "size_m": [40, 40], "spacing_m": 2, "bed_depth_m": 6, "hill_height_m": 1},
    "obstacles": [
        {"kind": "pipeline", "name": "ahead", "points_m": [[5, -8], [5, 8]], "radius_m": 0.3},
        {"kind": "pipeline", "name": "below", "points_m": [[-4, 3], [1, 3]], "radius_m": 0.3},
    ],
    "station": {
        "position_m": [0, 0, 0],
        "cameras": {"deck": {"position_m": [-3, 0, -2], "width": 24, "height": 16, "yaw_pitch_roll_deg": [0, 30, 0]}},
    },
    "warnings": {"range_m": 110, "proximity_m": 10},
    "vehicles": [
        {"name": "rov", "model": ROV, "start": {"position_m": [2, 0, -2]}, "sonar": SONAR},
        {"name": "auv", "model": AUV, "start": {"position_m": [-2, 3, -3]}, "battery": BATTERY, "sonar": SONAR | {
            "mode": "physics", "bending": True, "rays_per_beam": 4,
            "noise": {"level_db": 150, "detection_threshold_db": 5}}},
    ],
}  # fmt: skip

VARIANTS: dict[str, dict[str, Any]] = {
    "": {},
    "sea": {"surface": {"kind": "jonswap", "significant_height_m": 0.5, "peak_period_s": 3, "heading_deg": 10,
                        "component_count": 16, "spreading_exponent": 2, "depth_m": 5},
            "profile": {"kind": "linear", "bottom_depth_m": 8,
                        "surface": {"temperature_deg_c": 15, "salinity_psu": 10, "density_kg_m3": 1008},
                        "bottom": {"temperature_deg_c": 9, "salinity_psu": 20, "density_kg_m3": 1016}}},
    "cast": {"profile": {"kind": "table", "levels": [
        {"depth_m": 0, "temperature_deg_c": 15, "salinity_psu": 10, "density_kg_m3": 1005, "sound_speed_m_s": 1460},
        {"depth_m": 10, "temperature_deg_c": 9, "salinity_psu": 20, "density_kg_m3": 1015, "sound_speed_m_s": 1480},
    ]}},
}  # fmt: skip
"""Variants of the water, by name: the values that differ from WORLD."""


def world(variant: str = "") -> dict[str, Any]:
    """Return a scenario's values as a copy that the caller may change."""
    data: dict[str, Any] = json.loads(json.dumps(WORLD | ({"water": VARIANTS[variant]} if variant else {})))
    for vehicle in data["vehicles"]:
        vehicle["sonar"]["model"] = MULTIBEAM
    return data


def observed(sim: Simulator, *, pictures: bool, imaging: bool) -> dict[str, bytes]:
    """Fly for some steps and return everything observable."""
    seen: dict[str, bytes] = {}
    for what, found in watched(sim, pictures=pictures, imaging=imaging):
        seen[what] = seen.get(what, b"") + found
    return seen


def watched(sim: Simulator, *, pictures: bool, imaging: bool) -> Iterator[tuple[str, bytes]]:
    """Fly for some steps and yield everything observable, as soon as it is, with its name."""
    rov, auv = sim.vehicles.values()
    bed_m = sim.world.height_at([[2.0, 0.0], [-2.0, 3.0]])
    rov.place((2.0, 0.0, bed_m[0] + 0.4), (0, 0, 0, 1), (0.5, 0.4, -2, 0.3, 0.2, 0.1))
    rov.set_effort(0.5, 0.4, 0.3, 0.3, 0.3, 0.3)
    auv.place((-2.0, 3.0, bed_m[1] + 1.0), (0, 0, 0, 1), (1.5, 0.2, -2, 0.3, 0.2, 0.3))
    auv.set_effort(pitch=0.5)  # the fins hold this pitch
    auv.set_thrusters({"left": 0.8, "right": 0.5})
    for vehicle in (rov, auv):
        vehicle.sonar.aim(-0.5)
    for _ in range(10):
        sim.step(5)
        for vehicle in (rov, auv):
            yield "motion", _bytes(vehicle.pose.world_from_body, *vars(vehicle.velocity).values())
            yield "panel", _bytes(_panel(vehicle.telemetry()))
            yield "sensors", _bytes(*(_sample(sensor.sample()) for sensor in vehicle.sensors.values()))
            thrusts_n = [thruster.thrust_n for thruster in vehicle.thrusters.values()]
            yield "sensors", _bytes(*thrusts_n, *vehicle.battery.to_dict().values())
    for vehicle in (rov, auv):
        ping, sonar = vehicle.sonar.ping(), vehicle.sonar
        head = sonar.ping_rate_max_hz, sonar.elevation_rad
        yield "pings", _bytes(ping.ranges_m, ping.intensity_db, ping.angles_rad, *head)
    if pictures:
        yield "pictures", _bytes(rov.cameras["front"].capture().rgb, sim.cameras["deck"].capture().rgb)
    if imaging:
        aside = auv.imaging_sonars["aside"].line()
        below = auv.imaging_sonars["below"].profile([0.0, 0.9])
        yield "imaging", _bytes(rov.imaging_sonars["ahead"].look().level_db, below.level_db, below.ranges_m)
        yield "imaging", _bytes(aside.port_db, aside.starboard_db, aside.altitude_m)


def _bytes(*parts: Any) -> bytes:
    return b"".join(np.asarray(part).tobytes() for part in parts)


def _panel(panel: Any) -> list[float]:
    return np.hstack(list(panel.to_dict().values())).astype(float).tolist()


def _sample(sample: Any) -> np.ndarray[Any, Any]:
    value = sample.value if isinstance(sample.value, float) else np.hstack(list(vars(sample.value).values()))
    return np.hstack([value, sample.valid, sample.stamp_ns])
