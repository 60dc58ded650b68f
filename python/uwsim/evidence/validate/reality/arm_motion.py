"""The trials of arm_tilts.py with the arm itself, whose links have mass, buoyancy, added mass and drag.

The arm of bluerov2_heavy_alpha5 is on the hull of bluerov2_heavy, with the inertia and the added mass of its own file.
Its motors follow the measured joint angles, and the vehicle moves as the arm makes it move: beside pitch and roll, it
turns about the vertical when the base joint does, by the share of the arm's inertia in the whole one, with added
masses. Only the hull's three values of arm_tilts.py are fitted, to the other half of the trials.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.ndimage import uniform_filter1d
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, Curve, at_most, relative
from uwsim.evidence.validate.flights import deep_water
from uwsim.evidence.validate.reality import arm_tilts
from uwsim.evidence.validate.reality.arm_tilts import FILE, Trial, fitted_to_others, pitch_and_roll_deg
from uwsim.evidence.validate.reality.kinds import PREDICTED
from uwsim.scenario import VehicleModel, load_vehicle

__all__ = ["FILE", "Moved", "checks", "moved"]

GROUP = f"{PREDICTED}: Hinsdale, arm and motion"
COLUMNS = {"shoulder": ("e", 3.07), "upperarm": ("d", 0.0), "forearm": ("c", 0.0), "wrist": ("b", 2.879)}
"""By joint: its column in the files, and what the encoder reads where it is straight [rad]."""
SAMPLE_S, SETTLING_S = 0.05, 120.0
FASTEST_RAD_S = 8.0
SMOOTH, MEAN = 11, 81  # samples: of the rates, and of the running mean that is taken from them
TURNING_RAD_S = 0.1


@dataclass(frozen=True)
class Moved:
    """A simulated trial: pitch and roll (n, 2) [deg] and yaw rate (n,) [rad/s] at times_s (n,)."""

    times_s: Floats
    attitude_deg: Floats
    yaw_rate_rad_s: Floats


def moved(trial: Trial, hull_nm: Floats) -> Moved:
    """Return the motion of the vehicle, whose motors follow the joint angles of a trial, from rest."""
    first = {name: float(angle[0]) for name, angle in _angles(trial, trial.times_s[:1]).items()}
    sim = deep_water(_vehicle(first, hull_nm), density_kg_m3=arm_tilts.DENSITY_KG_M3)
    sim.advance(SETTLING_S)
    rov, arm = sim.rov, sim.rov.arm
    assert arm is not None
    times_s = np.arange(trial.times_s[0], trial.times_s[-1], SAMPLE_S)
    wanted = _angles(trial, times_s + SAMPLE_S)
    attitudes, rates = [], []
    for k in range(len(times_s)):
        attitudes.append(rov.pose.world_from_body[:3, :3])
        rates.append(float(rov.velocity.angular_body_rad_s[2]))
        now = dict(zip(arm.names, arm.read().positions, strict=True))
        speeds = {name: (angles[k] - now[name]) / SAMPLE_S for name, angles in wanted.items()}
        limits = -FASTEST_RAD_S, FASTEST_RAD_S
        arm.set_joints(speeds={name: float(np.clip(speed, *limits)) for name, speed in speeds.items()})
        sim.advance(SAMPLE_S)
    return Moved(times_s, pitch_and_roll_deg(Rotation.from_matrix(np.array(attitudes))), np.array(rates))


def _angles(trial: Trial, times_s: Floats) -> dict[str, Floats]:
    measured = trial.angles_rad(times_s)
    return {name: measured[column] - zero for name, (column, zero) in COLUMNS.items()}


def _vehicle(start_rad: dict[str, float], hull_nm: Floats) -> VehicleModel:
    """Return the vehicle, neutral, with the hull's moment and an arm that starts at these angles."""
    links = dict(load_vehicle("bluerov2_heavy_alpha5").arm or {})
    base = links.pop("armbase")  # part of the hull's fitted moment
    for name, link in links.items():
        changes: dict[str, object] = {"on": None, "position_m": base.position_m} if link.on == "armbase" else {}
        if link.hinge is not None and link.hinge.motor is not None:
            motor = link.hinge.motor.model_copy(update={"strongest_nm": 200.0, "fastest_deg_s": 500.0})
            start = {"start_deg": float(np.degrees(start_rad[name])), "limits_deg": None}
            changes["hinge"] = link.hinge.model_copy(update={"motor": motor, **start})
        links[name] = link.model_copy(update=changes)
    mass_kg = arm_tilts.HULL_KG + arm_tilts.ARM_BASE_KG
    displaced_kg = mass_kg + sum(link.mass_kg - arm_tilts.DENSITY_KG_M3 * link.volume_m3 for link in links.values())
    lift_m = np.asarray(hull_nm) / (arm_tilts.GRAVITY_M_S2 * displaced_kg)
    return load_vehicle("bluerov2_heavy").model_copy(
        update={
            "mass_kg": mass_kg,
            "volume_m3": displaced_kg / arm_tilts.DENSITY_KG_M3,
            "centre_of_mass_m": (0.0, 0.0, 0.0),
            "centre_of_buoyancy_m": tuple(lift_m.tolist()),
            "mesh_scale": arm_tilts.MESH_SCALE,
            "sensors": {},
            "sonar": None,
            "arm": links,
        }
    )


def turning(trial: Trial, got: Moved) -> Floats:
    """Return rates (3, n) while the base joint turns [rad/s]: its own, the measured and the simulated yaw rate.

    Each is without its mean over 4 s.
    """
    measured = np.interp(got.times_s, trial.times_s, trial.yaw_rate_rad_s)
    base = np.gradient(_smoothed(_angles(trial, got.times_s)["shoulder"]), SAMPLE_S)
    rates = np.stack([base, _smoothed(measured), _smoothed(got.yaw_rate_rad_s)])
    use = np.abs(base) > TURNING_RAD_S
    use[: MEAN // 2] = use[-(MEAN // 2) :] = False
    return np.asarray((rates - uniform_filter1d(rates, MEAN, axis=1))[:, use], np.float64)


def _smoothed(values: Floats) -> Floats:
    return np.asarray(uniform_filter1d(values, SMOOTH), np.float64)


def checks(data: Path) -> list[Check]:
    """Return the checks."""
    _, others = fitted_to_others(data)
    trials, flown = [trial for trial, _ in others], [moved(*each) for each in others]
    errors = np.array([
        arm_tilts.rms_deg(
            np.column_stack([np.interp(trial.times_s, got.times_s, got.attitude_deg[:, k]) for k in (0, 1)]), trial
        )
        for trial, got in zip(trials, flown, strict=True)
    ])  # fmt: skip
    rates = np.concatenate([turning(trial, got) for trial, got in zip(trials, flown, strict=True)], axis=1)
    measured, simulated = (float(np.polyfit(rates[0], rates[k], 1)[0]) for k in (1, 2))
    rates = rates[:, np.argsort(rates[0])]
    yaw = Curve(rates[0], {"measured": rates[1], "simulated": rates[2]}, "rate of the base joint [rad/s]", "rad/s")
    return [
        at_most(GROUP, f"{len(trials)} trials, none judged by its own fit: mean rms of pitch and roll", 0.45,
                float(errors.mean()), "deg"),
        replace(relative(GROUP, "yaw rate per rate of the base joint", measured, simulated, 0.2), curve=yaw),
    ]  # fmt: skip
