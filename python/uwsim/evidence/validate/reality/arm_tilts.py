"""Predicts the pitch and roll of a BlueROV2 that is tilted by its own arm in a wave basin from the joint angles alone.

Hannah Kolano and others, O. H. Hinsdale laboratory, Oregon State University, August 2023: github.com/hkolano/
UVMS-SysID-with-EAs (MIT); masses, volumes, centres and frames of the Reach Alpha 5 arm from that repository's URDF and
MagicNumAlpha.jl. The vehicle is at rest where gravity and buoyancy have no moment about its origin, so the upward
direction is parallel to

    h = sum over all parts of (buoyancy x centre of buoyancy - weight x centre of mass)     [N m], body frame.

The part of h that does not move with the arm, three values, is fitted to every other trial and tested on the trials in
between; then the two halves change roles.
"""

from __future__ import annotations

import csv
import lzma
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.spatial.transform import Rotation

from uwsim.evidence.validate.check import Check, at_most
from uwsim.figures.style import save_figure

Array = NDArray[np.float64]
FILE = "hinsdale/trials.csv"
GROUP = "Hinsdale, arm and tilt"
DENSITY_KG_M3, GRAVITY_M_S2 = 997.0, 9.81
WEIGHT_N = 13.17 * GRAVITY_M_S2  # weight of the vehicle without its arm, as stated by the authors
LIMIT_DEG = 0.42
START_NM = (1.960, -0.495, 3.825)  # from the authors' weights, volumes and positions
LEFT_OUT = ("baseline", "traj003-0-test")  # the arm does not move; a repetition of trial 003-1

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


def arm_moment_nm(angles_rad: dict[str, Array]) -> Array:
    """Return the moving links' part of h (n, 3) for joint angles (n,) by column b, c, d, e."""
    n = len(angles_rad["e"])
    turned, at = Rotation.from_quat(np.tile(BASE[1].as_quat(), (n, 1))), np.tile(BASE[0], (n, 1))
    moment = np.zeros((n, 3))
    for (offset, rpy, column, zero), links in zip(JOINTS, LINKS, strict=True):
        at = at + turned.apply(offset)
        turned = (
            turned
            * Rotation.from_euler("xyz", rpy)
            * Rotation.from_rotvec(np.outer(angles_rad[column] - zero, (0.0, 0.0, 1.0)))
        )
        for mass_kg, litres, mass_at, lift_at in links:
            lift_n, weight_n = DENSITY_KG_M3 * 1e-3 * litres * GRAVITY_M_S2, mass_kg * GRAVITY_M_S2
            moment += lift_n * (at + turned.apply(lift_at)) - weight_n * (at + turned.apply(mass_at))
    return moment


def tilt_deg(moment_nm: Array) -> Array:
    """Return pitch (nose down) and roll (n, 2) at rest, for the whole moment h (n, 3)."""
    x, y, z = moment_nm.T
    return np.asarray(np.degrees(np.column_stack([np.arctan2(-x, np.hypot(y, z)), np.arctan2(y, z)])), np.float64)


class Trial:
    """A trial: the arm's moment (n, 3), and the measured pitch and roll (n, 2) [deg] at times_s (n,)."""

    def __init__(self, folder: Path, name: str) -> None:
        self.name = name
        imu, joints = _columns(folder / f"{name}_imu.csv.xz"), _columns(folder / f"{name}_joint_states.csv.xz")
        inside = (imu["time_secs"] >= joints["time_secs"][0]) & (imu["time_secs"] <= joints["time_secs"][-1])
        self.times_s = imu["time_secs"][inside]
        order = np.argsort(joints["time_secs"], kind="stable")
        angles = {
            c: np.interp(self.times_s, joints["time_secs"][order], joints[f"axis_{c}_pos"][order]) for c in "bcde"
        }
        self.arm_nm = arm_moment_nm(angles)
        turned = Rotation.from_quat(np.column_stack([imu[f"{axis}_ori"][inside] for axis in "xyzw"]))
        self.measured_deg = turned.as_euler("ZYX", degrees=True)[:, 1:]


def read_trials(folder: Path) -> list[Trial]:
    """Return the trials in which the arm moves."""
    with (folder / "trials.csv").open(newline="", encoding="utf-8") as file:
        names = [row["trial"] for row in csv.DictReader(file)]
    return [Trial(folder, name) for name in names if not name.startswith(LEFT_OUT[0]) and name != LEFT_OUT[1]]


def fitted_nm(trials: list[Trial]) -> Array:
    """Return the constant part of h (3,) that minimises the squared tilt errors, with equal weight for each trial."""

    def misfit(constant: Array) -> Array:
        each = [(tilt_deg(t.arm_nm + constant) - t.measured_deg) / np.sqrt(len(t.times_s)) for t in trials]
        return np.concatenate(each).ravel()

    return np.asarray(least_squares(misfit, START_NM).x, np.float64)


def rms_deg(trial: Trial, constant_nm: Array) -> Array:
    """Return the root mean square errors of pitch and roll (2,)."""
    off = tilt_deg(trial.arm_nm + constant_nm) - trial.measured_deg
    return np.asarray(np.sqrt((off**2).mean(axis=0)))


def checks(data: Path, out: Path | None) -> list[Check]:
    """Return the checks; draw one of the tested trials, and all errors, into the folder `out`."""
    trials = read_trials((data / FILE).parent)
    halves = trials[::2], trials[1::2]
    fits = [fitted_nm(half) for half in halves]
    judged = {t.name: rms_deg(t, fits[1 - k]) for k, half in enumerate(halves) for t in half}
    errors = np.array(list(judged.values()))
    if out is not None:
        _draw(trials, {t.name: fits[1 - k] for k, half in enumerate(halves) for t in half}, judged, out)
    apart_m = float(np.linalg.norm(fits[0] - fits[1])) / WEIGHT_N
    return [
        at_most(GROUP, f"{len(trials)} trials, none judged by its own fit: mean rms", LIMIT_DEG, errors.mean(), "deg"),
        at_most(GROUP, "mean rms pitch", 0.50, errors[:, 0].mean(), "deg"),
        at_most(GROUP, "mean rms roll", 0.36, errors[:, 1].mean(), "deg"),
        at_most(GROUP, "two halves' lever from the centre of mass to that of buoyancy apart", 0.002, apart_m, "m"),
    ]


def _columns(path: Path) -> dict[str, Array]:
    """Return the columns of a file by name, without rows that have empty fields."""
    with lzma.open(path, "rt", encoding="utf-8") as file:
        rows = np.genfromtxt(file, delimiter=",", names=True)
    names = rows.dtype.names or ()
    whole = np.all([np.isfinite(rows[name]) for name in names], axis=0)
    return {name: np.asarray(rows[name][whole], np.float64) for name in names}


def _draw(trials: list[Trial], fits: dict[str, Array], judged: dict[str, Array], out: Path) -> None:
    figure, panels = plt.subplots(1, 2, figsize=(12, 4), layout="constrained", dpi=120)
    shown = max(trials, key=lambda t: float(np.ptp(t.measured_deg, axis=0).sum()))
    got = tilt_deg(shown.arm_nm + fits[shown.name])
    for k, (name, colour) in enumerate((("pitch", "C0"), ("roll", "C1"))):
        panels[0].plot(shown.times_s, shown.measured_deg[:, k], c=colour, lw=0.8, alpha=0.6, label=f"{name}, measured")
        panels[0].plot(shown.times_s, got[:, k], "--", c=colour, lw=1.5, label=f"{name}, from the joint angles")
    panels[0].set(xlabel="time [s]", ylabel="[deg]", title=f"{shown.name}, fitted to other trials")
    panels[0].legend(fontsize=8)
    rows = np.array(list(judged.values()))
    for k, name in enumerate(("pitch", "roll")):
        panels[1].bar(np.arange(len(rows)) + 0.4 * k, rows[:, k], 0.4, label=name)
    names = [name.removeprefix("traj").removeprefix("_") for name in judged]
    panels[1].set_xticks(np.arange(len(rows)) + 0.2, names, rotation=90, fontsize=7)
    panels[1].set(ylabel="rms error [deg]", title="each trial, fitted to others")
    panels[1].legend()
    save_figure(figure, out / "reality_arm_tilts.png")
    plt.close(figure)
