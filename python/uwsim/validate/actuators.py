"""Thrusters of the packaged vehicles, each alone, against their published figures and law.

A vehicle's actuator wrench is read off its motion: two simulators, one with the actuators and one without, make one
step from the same state; the difference of their velocities times the published mass is what the actuators did. Figures
are written here apart from the YAML files, and the law (Fossen 2011, Handbook, sec. 9.1) apart from the core.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq

from uwsim.scenario import VehicleModel, load_vehicle
from uwsim.simulator import Simulator
from uwsim.validate.check import Check, along, relative, within
from uwsim.validate.flights import START_M, deep_water, fly
from uwsim.validate.published import BLUEROV2_HEAVY, PUBLISHED
from uwsim.validate.reference import Array, Coefficients

STEP_S = 0.0005
SETTLED = 16  # time constants
LEVEL, NOSE_DOWN = (0.0, 0.0, 0.0, 1.0), (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))
STILL = (0.0,) * 6
WRENCH_TOLERANCE, HEIGHT_TOLERANCE = 1e-3, 5e-3


@dataclass(frozen=True)
class Propeller:
    """table: command, N. Of the thrust: lag, diameter, K_T at rest, J without thrust, torque per newton."""

    table: tuple[tuple[float, float], ...]
    time_constant_s: float
    diameter_m: float
    bollard: float
    zero_thrust_advance: float
    torque_per_thrust_m: float

    def thrust_n(self, still_n: float, inflow_m_s: float, density_kg_m3: float) -> float:
        """What is left of the still-water thrust."""
        slope = self.diameter_m / self.zero_thrust_advance * np.sqrt(density_kg_m3 * self.bollard * abs(still_n))
        return float(still_n - slope * inflow_m_s)


# Blue Robotics, September 2019: us, N at 16 V. Lag: slowest pole of von Benzon et al. 2022. K_T: 51.5 N at 3533 rpm.
# Ours, with their reasons in the YAML file: J without thrust, torque.
T200_PWM_N = (
    (1100, -39.9), (1200, -26.6), (1300, -14.1), (1400, -4.71), (1472, 0.0),
    (1528, 0.0), (1600, 5.88), (1700, 17.85), (1800, 33.5), (1900, 51.5),
)  # fmt: skip
T200 = Propeller(tuple(((us - 1500) / 400, n) for us, n in T200_PWM_N), 0.076, 0.076, 0.445, 0.976, 0.0153)

# Fossen's remus100.py: (1 - t) rho D^4 K_T0 n|n| with t = 0.1, D = 0.14 m, K_T0 = 0.4566, 1525 rpm, T_n = 1 s; the wake
# as 0.944 of the speed. K_T falls to none at J = 1.0942, linearly through 0.1798 at 0.6632. Torque: D K_Q0 / ((1-t)
# K_T0), K_Q0 = 0.07, rounded.
_REMUS_FULL_N = 0.9 * 1026 * 0.14**4 * 0.4566 * (1525 / 60) ** 2
REMUS_PROPELLER = Propeller(
    tuple((k / 10, _REMUS_FULL_N * k * abs(k) / 100) for k in range(-10, 11)),
    1.0, 0.14, 0.9 * 0.4566, 1.0942 / 0.944, 0.0238,
)  # fmt: skip


@dataclass(frozen=True)
class Mount:
    """Where a propeller is, where it pushes, and which way it turns: 1 right-handed, -1 left-handed."""

    position_m: tuple[float, float, float]
    axis: tuple[float, float, float]
    spin: int
    kind: Propeller = T200

    @property
    def unit(self) -> Array:
        """The axis, of length 1."""
        return np.asarray(self.axis, np.float64) / np.linalg.norm(self.axis)

    def wrench(self, thrust_n: float) -> Array:
        """Force, and its moment and the propeller's torque about the origin: (6,)."""
        force = thrust_n * self.unit
        return np.concatenate(
            [force, np.cross(self.position_m, force) - self.spin * self.kind.torque_per_thrust_m * force]
        )

    def inflow_m_s(self, velocity: Sequence[float] | Array) -> float:
        """Speed of the hub along the axis."""
        return float(self.unit @ (np.asarray(velocity[:3]) + np.cross(velocity[3:], self.position_m)))


# Places: von Benzon et al. 2022, table A1. Axes and spins: Blue Robotics' and ArduSub's "vectored" frames.
_VECTORED = {
    "front_left": Mount((0.14, 0.092, 0), (-1, 1, 0), -1),
    "front_right": Mount((0.14, -0.092, 0), (-1, -1, 0), -1),
    "rear_left": Mount((-0.15, 0.092, 0), (1, 1, 0), 1),
    "rear_right": Mount((-0.15, -0.092, 0), (1, -1, 0), 1),
}
_UP = (0.0, 0.0, 1.0)
# The two verticals: Blue Robotics' drawing, scaled.
_STANDARD = {
    **_VECTORED,
    "vertical_left": Mount((0, 0.111, 0.07), _UP, 1),
    "vertical_right": Mount((0, -0.111, 0.07), _UP, -1),
}
MOUNTS: dict[str, dict[str, Mount]] = {
    "bluerov2_heavy": {
        **_VECTORED,
        "vertical_front_left": Mount((0.118, 0.215, 0.064), _UP, 1),
        "vertical_front_right": Mount((0.118, -0.215, 0.064), _UP, -1),
        "vertical_rear_left": Mount((-0.118, 0.215, 0.064), _UP, -1),
        "vertical_rear_right": Mount((-0.118, -0.215, 0.064), _UP, 1),
    },
    "bluerov2_wu": _STANDARD,
    "bluerov2_tank": _STANDARD,
    "remus100": {"propeller": Mount((-0.8, 0, 0), (1, 0, 0), -1, REMUS_PROPELLER)},
}


class Probe:
    """One vehicle with its actuators and the same without, in deep water."""

    def __init__(self, name: str, model: VehicleModel | None = None) -> None:
        used = model or load_vehicle(name)
        none = {"max_force_n": (0.0,) * 3, "max_torque_nm": (0.0,) * 3, "thrusters": {}, "fins": {}}
        self.body = PUBLISHED[name]
        self._driven, self._bare = (self._fine(m) for m in (used, used.model_copy(update=none)))
        self.rov = self._driven.rov

    def _fine(self, model: VehicleModel) -> Simulator:
        coarse = deep_water(model, density_kg_m3=self.body.water_density_kg_m3)
        return Simulator(coarse.scenario.model_copy(update={"step_s": STEP_S}))

    def run(self, duration_s: float) -> None:
        """Let actuators follow their commands, from rest in the deep."""
        self.rov.place(START_M)
        self._driven.advance(round(duration_s / STEP_S) * STEP_S)

    def thrusters(self, commands: Mapping[str, float], kind: Propeller) -> None:
        """Command them and wait until their thrust is there."""
        self.rov.set_thrusters(commands)
        self.run(SETTLED * kind.time_constant_s)

    def wrench(
        self,
        velocity: Sequence[float] | Array = STILL,
        at_m: Sequence[float] = START_M,
        attitude_xyzw: Sequence[float] = LEVEL,
    ) -> Array:
        """Of the actuators, (6,): M times the difference of the accelerations, resistance taken at mid-step."""
        after = []
        for sim in (self._driven, self._bare):
            sim.rov.place(at_m, attitude_xyzw, velocity)
            sim.step()
            after.append(np.concatenate([sim.rov.velocity.linear_body_m_s, sim.rov.velocity.angular_body_rad_s]))
        rate = self.body.mass @ (after[0] - after[1]) / STEP_S
        return np.asarray(rate + 0.5 * (_resistance(self.body, after[0]) - _resistance(self.body, after[1])))


def _resistance(body: Coefficients, nu: Array) -> Array:
    """Coriolis and centripetal terms and damping (6,), as published."""
    momentum = body.mass @ nu
    p, v, w = momentum[:3], nu[:3], nu[3:]
    damping = (np.asarray(body.linear_damping) + np.asarray(body.quadratic_damping) * np.abs(nu)) * nu
    return np.asarray(damping + np.concatenate([np.cross(w, p), np.cross(w, momentum[3:]) + np.cross(v, p)]))


def wrench_checks(group: str, name: str, expected: Array, got: Array) -> Iterator[Check]:
    """Force and moment of wrenches (..., 6), each relative to its largest magnitude, 0.1 at least."""
    for what, part, unit in (("force", slice(0, 3), "N"), ("moment", slice(3, 6), "N m")):
        want, found = expected[..., part], got[..., part]
        scale = max(float(np.linalg.norm(want, axis=-1).max()), 0.1)
        yield along(group, f"{name}: {what}", want.ravel(), found.ravel(), scale, WRENCH_TOLERANCE, unit)


def thrust_tables(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """Each point of the table, and the dead band: nothing in it, and half-way to its neighbours half of theirs."""
    probe, (thruster, mount) = Probe(name, model), next(iter(MOUNTS[name].items()))
    commands, thrusts = np.array(mount.kind.table).T
    middles = 0.5 * (commands[1:] + commands[:-1])
    by_the_band = middles[(thrusts[1:] == 0) | (thrusts[:-1] == 0)]
    for command in np.sort(np.concatenate([commands, by_the_band])):
        probe.thrusters({thruster: float(command)}, mount.kind)
        got, expected = probe.rov.thrusters[thruster].thrust_n, float(np.interp(command, commands, thrusts))
        label = f"thrust at command {command:.4g}"
        if expected:
            yield relative(name, label, expected, got, 5e-3, "N")  # the propeller's table is rounded to 0.01 N
        else:
            yield within(name, label, 0.0, got, 1.0, 1e-4, "N")


def thruster_wrenches(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """Each thruster alone, full ahead and full astern, at rest: its force, r x F and the propeller's torque."""
    probe = Probe(name, model)
    for thruster, mount in MOUNTS[name].items():
        expected, got = [], []
        for command, thrust_n in (mount.kind.table[-1], mount.kind.table[0]):
            probe.thrusters({thruster: command}, mount.kind)
            expected.append(mount.wrench(thrust_n))
            got.append(probe.wrench())
        yield from wrench_checks(name, thruster, np.array(expected), np.array(got))
        torque, found = (float(wrenches[0][3:] @ mount.unit) for wrenches in (expected, got))  # r x F has none there
        yield relative(name, f"{thruster}: reaction torque", torque, found, WRENCH_TOLERANCE, "N m")


def thruster_heights(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """How high a thruster sits along its own axis turns no moment: it shows where it comes out of the water."""
    probe = Probe(name, model)
    for thruster, mount in MOUNTS[name].items():
        upright = abs(mount.unit[2]) == 1
        if not upright and abs(mount.unit[0]) != 1:
            continue
        probe.thrusters({thruster: 1.0}, mount.kind)
        height_m = mount.position_m[2] if upright else -mount.position_m[0]
        axis, attitude = (2, LEVEL) if upright else (0, NOSE_DOWN)
        wet, dry = -height_m - 0.05, -height_m + 0.05
        while dry - wet > 1e-5:
            middle = 0.5 * (wet + dry)
            works = abs(probe.wrench(at_m=(0.0, 0.0, middle), attitude_xyzw=attitude)[axis]) > 1e-3
            wet, dry = (middle, dry) if works else (wet, middle)
        yield relative(name, f"{thruster}: height of the hub", height_m, -0.5 * (wet + dry), HEIGHT_TOLERANCE, "m")


def thruster_lag(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """From rest to full: 63.2 % of the force after one time constant."""
    probe = Probe(name, model)
    thruster, mount = next(iter(MOUNTS[name].items()))
    command, full_n = mount.kind.table[-1]
    probe.rov.set_thrusters({thruster: command})
    probe.run(mount.kind.time_constant_s - STEP_S)
    steps = [float(probe.wrench()[:3] @ mount.unit) / full_n for _ in range(2)]  # means before and after that moment
    yield relative(name, f"{thruster}: share of thrust after a time constant", 1 - np.exp(-1), 0.5 * sum(steps), 1e-3)


def advance_loss(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """What of the thrust is lost to inflow: the vehicle moves and turns. What it does without thrust is taken off."""
    probe = Probe(name, model)
    velocity = np.array([1.2, -0.4, 0.3, 0.2, -0.3, 0.4])
    idle = probe.wrench(velocity)  # fins have some lift
    for thruster, mount in list(MOUNTS[name].items())[::3]:
        command, still_n = mount.kind.table[-1]
        probe.thrusters({thruster: command}, mount.kind)
        thrust_n = mount.kind.thrust_n(still_n, mount.inflow_m_s(velocity), probe.body.water_density_kg_m3)
        got = float((probe.wrench(velocity) - idle)[:3] @ mount.unit)
        yield relative(name, f"{thruster}: thrust lost to inflow", still_n - thrust_n, still_n - got, 5e-3, "N")


def driven_terminal_speed(name: str = "bluerov2_heavy", model: VehicleModel | None = None) -> Iterator[Check]:
    """BlueROV2 Heavy, trimmed neutral, ahead and up under effort: thrust that the inflow leaves equals the drag.

    The horizontal thrusters pull at 45 degrees. Full effort ahead is 39.9 N of each in front and 51.5 N of each behind,
    of which less than 0.87 is shared out evenly; the verticals have 51.5 N each.
    """
    body, used = BLUEROV2_HEAVY, model or load_vehicle(name)
    slanted, ahead_n = np.sqrt(0.5), 0.5 * (39.9 + 51.5)
    for axis, effort, cosine, full_n in ((0, 0.8, slanted, ahead_n), (0, 0.4, slanted, ahead_n), (2, 1.0, 1.0, 51.5)):
        density = body.mass_kg / body.volume_m3

        def excess(
            speed: float, k: int = axis, c: float = cosine, t: float = effort * full_n, rho: float = density
        ) -> float:
            drag = body.linear_damping[k] * speed + body.quadratic_damping[k] * speed * abs(speed)
            return 4 * c * T200.thrust_n(t, c * speed, rho) - drag

        what = ("surge", "sway", "heave")[axis]
        sim = deep_water(used, density_kg_m3=density)
        sim.rov.set_effort(**{what: effort})
        reached = float(fly(sim, STILL, 5.0).velocities[-1, axis])
        yield relative(name, f"terminal speed, {what} effort {effort:g}", brentq(excess, 0, 5), reached, 1e-3, "m/s")


def thruster_checks() -> list[Check]:
    """All of them; the two standard BlueROV2 carry the T200 that the heavy one's checks see."""
    checks = [c for name in MOUNTS for law in (thruster_wrenches, thruster_heights) for c in law(name)]
    for name in ("bluerov2_heavy", "remus100"):
        checks += [c for law in (thrust_tables, thruster_lag, advance_loss) for c in law(name)]
    return [*checks, *driven_terminal_speed()]
