"""A BlueROV2 is tilted by its own arm in a wave basin: flown in the simulator, with weights that follow the joints.

Hannah Kolano and others, O. H. Hinsdale laboratory, Oregon State University, August 2023: github.com/hkolano/
UVMS-SysID-with-EAs (MIT); masses, volumes, centres and frames of the Reach Alpha 5 arm from that repository's URDF and
MagicNumAlpha.jl. The flown vehicle has the added mass and damping of Wu 2018, which the authors use as well. Its centre
of mass and its centre of buoyancy are parameters that follow the measured joint angles; its pitch and roll are those of
the simulator.

The angles alone do not determine them: the hull, its foam and its weights have a moment of their own,

    h = buoyancy x centre of buoyancy - weight x centre of mass     [N m], body frame,

three values, which are those of the authors or fitted to every other trial; the trials in between judge the fit, and
vice versa. The fit needs no simulator: at rest, h of the hull and of the arm together point up.
"""

from __future__ import annotations

import lzma
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.base.texts.csv_table import read_csv
from uwsim.evidence.validate.check import Check, Curve, at_most
from uwsim.evidence.validate.flights import deep_water
from uwsim.evidence.validate.reality.kinds import PREDICTED
from uwsim.scenario import load_vehicle

FILE = "hinsdale/trials.csv"
GROUP = f"{PREDICTED}: Hinsdale, arm and tilt"
DENSITY_KG_M3, GRAVITY_M_S2 = 997.0, 9.81
HULL_KG, ARM_BASE_KG = 13.17, 0.341  # as stated by the authors; the foam and the weights have no stated mass
STATED_HULL_NM = (1.960, -0.495, 3.825)  # from the authors' weights, volumes and positions
LEFT_OUT = ("baseline", "traj003-0-test")  # the arm does not move; a repetition of trial 003-1
MESH_SCALE = 1.1  # the mesh is smaller than this vehicle with its foam; deep in still water its shape has no effect
SETTLING_S, CHANGE_S, SAMPLE_S = 60.0, 0.5, 0.05
FLOWN = slice(None)  # of the trials; the hull is fitted to all

BASE = (np.array([0.25, -0.10965, 0.005]), Rotation.identity())
JOINTS = (  # translation [m], rpy [rad], column, zero [rad]
    ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), "e", 3.07),
    ((0.020, 0.0, 0.046), (1.57075, 1.3, 0.0), "d", 0.0),
    ((0.15, 0.0, 0.0), (3.1415, 0.0, 1.3), "c", 0.0),
    ((0.020, 0.0, 0.0), (-1.57075, 0.0, 0.0), "b", 2.879),
)
LINKS = (  # after each joint: mass [kg], volume [l], centres of mass and buoyancy in the link's frame [m]
    ((0.194, 0.018, (0.005, -0.001, 0.016), (-0.001, -0.003, 0.032)),),
    ((0.429, 0.203, (0.073, 0.0, 0.0), (0.073, 0.0, -0.002)),),
    ((0.115, 0.025, (0.017, -0.026, -0.002), (0.003, 0.001, -0.017)),),
    (
        (0.333, 0.155, (0.0, 0.0, -0.098), (0.0, 0.0, -0.098)),
        (0.05, 0.02, (0.0, 0.0, -0.190), (0.0, 0.0, -0.190)),
    ),
)
MASS_KG = HULL_KG + ARM_BASE_KG + sum(link[0] for links in LINKS for link in links)


@dataclass(frozen=True)
class Arm:
    """The moving links: sums of mass x centre of mass and of volume x centre of buoyancy (n, 3), body frame."""

    mass_kg_m: Floats
    volume_m4: Floats

    @property
    def moment_nm(self) -> Floats:
        """The links' part of h (n, 3)."""
        return GRAVITY_M_S2 * (DENSITY_KG_M3 * self.volume_m4 - self.mass_kg_m)


def arm_at(angles_rad: dict[str, Floats]) -> Arm:
    """Return the moving links for joint angles (n,) by column b, c, d, e."""
    n = len(angles_rad["e"])
    turned, at = Rotation.from_quat(np.tile(BASE[1].as_quat(), (n, 1))), np.tile(BASE[0], (n, 1))
    masses, volumes = np.zeros((n, 3)), np.zeros((n, 3))
    for (offset, rpy, column, zero), links in zip(JOINTS, LINKS, strict=True):
        at = at + turned.apply(offset)
        about_axis = Rotation.from_rotvec(np.outer(angles_rad[column] - zero, (0.0, 0.0, 1.0)))
        turned = turned * Rotation.from_euler("xyz", rpy) * about_axis
        for mass_kg, litres, mass_at, lift_at in links:
            masses += mass_kg * (at + turned.apply(mass_at))
            volumes += 1e-3 * litres * (at + turned.apply(lift_at))
    return Arm(masses, volumes)


class Trial:
    """A trial: joint angles, measured attitude, with pitch and roll (n, 2) [deg], and yaw rate, at times_s (n,)."""

    def __init__(self, folder: Path, name: str) -> None:
        self.name = name
        imu, self._joints = (_columns(folder / f"{name}_{part}.csv.xz") for part in ("imu", "joint_states"))
        order = np.argsort(self._joints["time_secs"], kind="stable")
        self._joints = {column: values[order] for column, values in self._joints.items()}
        first_s, last_s = self._joints["time_secs"][[0, -1]]
        inside = (imu["time_secs"] >= first_s) & (imu["time_secs"] <= last_s)
        self.times_s = imu["time_secs"][inside]
        self.attitude = Rotation.from_quat(np.column_stack([imu[f"{axis}_ori"][inside] for axis in "xyzw"]))
        self.yaw_rate_rad_s = imu["z_angvel"][inside]
        self.measured_deg = pitch_and_roll_deg(self.attitude)

    def angles_rad(self, times_s: Floats) -> dict[str, Floats]:
        """Return the joint angles (n,) at given times (n,), by column b, c, d, e."""
        joints = self._joints
        return {c: np.interp(times_s, joints["time_secs"], joints[f"axis_{c}_pos"]) for c in "bcde"}

    def arm(self, times_s: Floats) -> Arm:
        """Return the arm at given times (n,)."""
        return arm_at(self.angles_rad(times_s))


def pitch_and_roll_deg(world_from_body: Rotation) -> Floats:
    """Return pitch, positive nose down, and roll (n, 2) [deg]."""
    return np.asarray(world_from_body.as_euler("ZYX", degrees=True)[:, 1:], np.float64)


def read_trials(folder: Path) -> list[Trial]:
    """Return the trials in which the arm moves."""
    names = read_csv(folder / "trials.csv").texts("trial")
    return [Trial(folder, name) for name in names if not name.startswith(LEFT_OUT[0]) and name != LEFT_OUT[1]]


def fitted_hull_nm(trials: list[Trial]) -> Floats:
    """Return h of the hull (3,), by linear least squares, with equal weight for each trial.

    The measured upward direction u is parallel to the hull's h plus the arm's a: u x h = -u x a.
    """
    matrices, moments = [], []
    for trial in trials:
        up = trial.attitude.inv().apply((0.0, 0.0, 1.0))
        weight = 1.0 / math.sqrt(len(up))
        columns = [np.cross(up, axis) for axis in np.eye(3)]
        matrices.append(weight * np.stack(columns, axis=-1).reshape(-1, 3))
        moments.append(-weight * np.cross(up, trial.arm(trial.times_s).moment_nm).ravel())
    return np.asarray(np.linalg.lstsq(np.concatenate(matrices), np.concatenate(moments))[0], np.float64)


def fitted_to_others(data: Path) -> tuple[list[Floats], list[tuple[Trial, Floats]]]:
    """Return h of the hull (3,) by each half of the trials, and the trials to fly, each with h by the other half."""
    trials = read_trials((data / FILE).parent)
    fits = [fitted_hull_nm(half) for half in (trials[::2], trials[1::2])]
    return fits, [(trial, fits[1 - k % 2]) for k, trial in enumerate(trials)][FLOWN]


def flown_deg(arm: Callable[[Floats], Arm], hull_nm: Floats, times_s: Floats) -> Floats:
    """Return pitch and roll (n, 2) [deg] of the simulated vehicle at times_s (n,), increasing.

    It first comes to rest with the arm as at the first time. Then its centres follow the arm, every CHANGE_S. It has no
    net weight, and its thrusters are off.
    """
    volume_m3 = MASS_KG / DENSITY_KG_M3
    model = load_vehicle("bluerov2_wu").model_copy(
        update={"mass_kg": MASS_KG, "volume_m3": volume_m3, "mesh_scale": MESH_SCALE, "sensors": {}, "sonar": None}
    )
    sim = deep_water(model, density_kg_m3=DENSITY_KG_M3)
    starts_s = np.arange(times_s[0], times_s[-1], CHANGE_S)
    arms = arm(starts_s + 0.5 * CHANGE_S)  # as halfway to the next change, so that the centres do not lag
    masses, volumes = arms.mass_kg_m / MASS_KG, arms.volume_m4 / volume_m3
    hull_m = np.asarray(hull_nm) / (MASS_KG * GRAVITY_M_S2)
    sampled_s, attitudes = [], []

    def fly(centre_of_mass_m: Floats, arm_lift_m: Floats, steps: int, from_s: float) -> None:
        sim.parameters.update(
            {"body.centre_of_mass_m": centre_of_mass_m, "body.centre_of_buoyancy_m": hull_m + arm_lift_m}
        )
        for step in range(steps):
            sampled_s.append(from_s + step * SAMPLE_S)
            attitudes.append(sim.rov.pose.world_from_body[:3, :3])
            sim.advance(SAMPLE_S)

    first = arm(times_s[:1])
    fly(first.mass_kg_m[0] / MASS_KG, first.volume_m4[0] / volume_m3, round(SETTLING_S / SAMPLE_S), -SETTLING_S)
    sampled_s.clear()
    attitudes.clear()
    for start_s, mass_m, lift_m in zip(starts_s, masses, volumes, strict=True):
        fly(mass_m, lift_m, round(CHANGE_S / SAMPLE_S), start_s)
    got = pitch_and_roll_deg(Rotation.from_matrix(np.array(attitudes)))
    return np.column_stack([np.interp(times_s, sampled_s, got[:, k]) for k in (0, 1)])


def rms_deg(got_deg: Floats, trial: Trial) -> Floats:
    """Return the root mean square errors of pitch and roll (2,)."""
    return np.asarray(np.sqrt(((got_deg - trial.measured_deg) ** 2).mean(axis=0)))


def checks(data: Path) -> list[Check]:
    """Return the checks, with pitch and roll of the trial that tilts most."""
    fits, others = fitted_to_others(data)
    trials = [trial for trial, _ in others]
    flown = {t.name: flown_deg(t.arm, hull_nm, t.times_s) for t, hull_nm in others}
    errors = np.array([rms_deg(flown[t.name], t) for t in trials])
    shown = max(trials, key=lambda t: float(np.ptp(t.measured_deg, axis=0).sum()))
    curves = [
        Curve(shown.times_s, {"measured": shown.measured_deg[:, k], "simulated": flown[shown.name][:, k]}, up="deg",
              title=f"{shown.name}, hull fitted to other trials: {name}")
        for k, name in enumerate(("pitch", "roll"))
    ]  # fmt: skip
    stated = np.mean([rms_deg(flown_deg(t.arm, np.array(STATED_HULL_NM), t.times_s), t) for t in trials])
    apart_m = float(np.linalg.norm(fits[0] - fits[1])) / (HULL_KG * GRAVITY_M_S2)
    return [
        at_most(GROUP, f"{len(trials)} trials, none judged by its own fit: mean rms", 0.42, errors.mean(), "deg"),
        replace(at_most(GROUP, "mean rms pitch", 0.50, errors[:, 0].mean(), "deg"), curve=curves[0]),
        replace(at_most(GROUP, "mean rms roll", 0.36, errors[:, 1].mean(), "deg"), curve=curves[1]),
        at_most(GROUP, "with the hull as the authors state it, nothing fitted: mean rms", 0.9, float(stated), "deg"),
        at_most(GROUP, "two halves' lever from the centre of mass to that of buoyancy apart", 0.002, apart_m, "m"),
    ]


def _columns(path: Path) -> dict[str, Floats]:
    """Return the columns of a file by name, without rows that have empty fields."""
    table = read_csv(path, data=lzma.decompress(path.read_bytes()))
    rows = {name: table.numbers(name, may_lack=True) for name in table.columns}
    whole = np.all([np.isfinite(values) for values in rows.values()], axis=0)
    return {name: values[whole] for name, values in rows.items()}
