"""Checks REMUS 100's fins and hull lift, alone and in a turn under propulsion, against published values and laws.

The values are repeated here independently of the YAML file, and the law (Beard and McLain 2012, Small Unmanned
Aircraft, ch. 4) independently of the core. The turn is integrated by SciPy.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import lru_cache

import numpy as np
from scipy.integrate import solve_ivp

from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, along, relative
from uwsim.evidence.validate.flights import deep_water, fly, times
from uwsim.evidence.validate.motion.actuator_probe import STILL, Probe, wrench_checks
from uwsim.evidence.validate.motion.published import REMUS_100
from uwsim.evidence.validate.motion.published_thrusters import MOUNTS
from uwsim.evidence.validate.motion.reference_solution import GRAVITY_M_S2, cross_matrix
from uwsim.scenario import VehicleModel, load_vehicle

# Tail fins: Prestero 2001. Hull, vertical and lateral: Fossen's remus100.py, area 0.7 L D, aspect ratio D^2 / S,
# efficiency 0.7. Values chosen for uwsim, for the reasons given in the YAML file: positions, profile drag, stall (2
# degrees wide), rate, the tail's efficiency.
FINS = ("port", "starboard", "top", "bottom")
_SPAN = np.array([(0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (0, 1, 0), (0, 0, 1)], np.float64)
_PLACE = np.array([(-0.73, 0, 0)] * 4 + [(-0.24, 0, 0)] * 2) + 0.1 * _SPAN * np.array([[1]] * 4 + [[0]] * 2)
_AREA_M2 = np.array([0.00665] * 4 + [0.7 * 1.6 * 0.19] * 2)
_ASPECT = np.array([2.21] * 4 + [0.19**2 / (0.7 * 1.6 * 0.19)] * 2)
_PROFILE_DRAG, _EFFICIENCY = np.array([0.01] * 4 + [0.0] * 2), np.array([0.9] * 4 + [0.7] * 2)
_STALL_RAD, _STALL_WIDTH_RAD = np.radians([20] * 4 + [1000] * 2), np.radians(2)
_ACROSS = np.cross((1.0, 0.0, 0.0), _SPAN)
_MOST_DEG, _RATE_DEG_S = 15.0, 90.0


def fins_wrench(velocity: Floats, angles_rad: Mapping[str, float]) -> Floats:
    """Return the wrench (6,) of REMUS 100's fins and hull: the lift and drag of each in the flow at its position."""
    there = velocity[:3] + _PLACE @ cross_matrix(velocity[3:]).T
    ahead, across = there[:, 0], np.einsum("ni,ni->n", there, _ACROSS)
    speed2 = ahead**2 + across**2
    attack = np.arctan2(-across, ahead) - [*(angles_rad.get(fin, 0.0) for fin in FINS), 0.0, 0.0]
    sine, cosine = np.sin(attack), np.cos(attack)
    lift = np.pi * _ASPECT / (1 + np.sqrt(1 + _ASPECT**2 / 4)) * sine * cosine
    drag = lift**2 / (np.pi * _EFFICIENCY * _ASPECT)
    stalled = 0.5 * (1 + np.tanh(0.5 * (np.abs(attack) - _STALL_RAD) / _STALL_WIDTH_RAD))
    lift += stalled * (2 * sine * np.abs(sine) * cosine - lift)
    drag += stalled * (2 * np.abs(sine) ** 3 - drag) + _PROFILE_DRAG
    pressed = 0.5 * REMUS_100.water_density_kg_m3 * _AREA_M2 * np.sqrt(speed2)
    along_x, along_n = pressed * (-lift * across - drag * ahead), pressed * (lift * ahead - drag * across)
    forces = along_n[:, None] * _ACROSS
    forces[:, 0] += along_x
    return np.concatenate([forces.sum(axis=0), np.einsum("nij,nj->i", _PLACE_CROSS, forces)])


_PLACE_CROSS = np.array([cross_matrix(place) for place in _PLACE])


def fin_wrenches(name: str = "remus100", model: VehicleModel | None = None) -> Iterator[Check]:
    """Check the drag without deflection, each fin's lift at 10 degrees and in stall, and the hull's lift and drag."""
    probe, ahead = Probe(name, model), np.array([2.0, 0, 0, 0, 0, 0])
    cases: list[tuple[str, Floats, dict[str, float]]] = [("fins centred", ahead, {})]
    cases += [(f"{fin} at 10 deg", ahead, {fin: 10.0}) for fin in FINS]
    for fin, axis, side in (("port", 2, -1), ("starboard", 2, 1), ("top", 1, 1), ("bottom", 1, -1)):
        drift = ahead + 2 * np.tan(np.radians(6)) * np.eye(6)[axis]
        cases.append((f"{fin} in stall, 21 deg", drift, {fin: 15.0 * side}))
    cases += [
        (f"drift of 20 deg in {what}", ahead + 0.73 * np.eye(6)[k], {}) for what, k in (("sway", 1), ("heave", 2))
    ]
    for what, velocity, degrees in cases:
        angles = {fin: float(np.radians(degree)) for fin, degree in degrees.items()}
        probe.rov.set_fins(angles)
        probe.run(0.5)
        yield from wrench_checks(name, what, fins_wrench(velocity, angles), probe.wrench(velocity))


def fin_travel(name: str = "remus100", model: VehicleModel | None = None) -> Iterator[Check]:
    """Check that full effort turns the fins at their rate to their limit, in the direction for port or nose down."""
    probe = Probe(name, model)
    for effort, sides in (("yaw", {"top": -1, "bottom": 1}), ("pitch", {"port": -1, "starboard": 1})):
        probe.rov.set_effort(**{effort: 1.0})
        for duration_s in (0.1, 0.4):
            probe.run(duration_s)
            for fin, side in sides.items():
                expected = side * min(_MOST_DEG, _RATE_DEG_S * 0.1 if duration_s == 0.1 else np.inf)
                label = f"{fin}: angle {0.1 if duration_s == 0.1 else 0.5:g} s into full {effort}"
                yield relative(name, label, expected, float(np.degrees(probe.rov.fins[fin])), 1e-6, "deg")


TURN_S, TURN_SURGE, TURN_YAW = 40.0, 0.7, 0.5
PATH_TOLERANCE, STEADY_TOLERANCE = 4e-3, 1e-3


@lru_cache(maxsize=1)
def _turn() -> tuple[Floats, Floats]:
    """Return the positions (n, 3) and velocities (n, 6) of REMUS 100 from rest under TURN_SURGE and TURN_YAW."""
    body, mount = REMUS_100, MOUNTS["remus100"]["propeller"]
    mass, inverse = body.mass, np.linalg.inv(body.mass)
    weight_n = body.mass_kg * GRAVITY_M_S2

    def rate(t: float, y: Floats) -> Floats:
        attitude, momentum = y[3:12].reshape(3, 3), y[12:]
        nu = inverse @ momentum
        still_n = TURN_SURGE * mount.propeller.table[-1][1] * -np.expm1(-t / mount.propeller.time_constant_s)
        rudder = np.radians(min(_RATE_DEG_S * t, TURN_YAW * _MOST_DEG))
        thrust_n = mount.propeller.thrust_n(still_n, mount.inflow_m_s(nu), body.water_density_kg_m3)
        wrench = mount.wrench(thrust_n) + fins_wrench(nu, {"top": -rudder, "bottom": rudder})
        wrench -= (np.asarray(body.linear_damping) + np.asarray(body.quadratic_damping) * np.abs(nu)) * nu
        wrench[3:] += np.cross(body.centre_of_mass_m, -weight_n * attitude[2])  # neutral: the net force is zero
        turning = cross_matrix(nu[3:])
        force = wrench[:3] - turning @ momentum[:3]
        moment = wrench[3:] - turning @ momentum[3:] - np.cross(nu[:3], momentum[:3])
        return np.concatenate([attitude @ nu[:3], (attitude @ turning).ravel(), force, moment])

    start = np.concatenate([np.zeros(3), np.eye(3).ravel(), mass @ np.zeros(6)])
    y = solve_ivp(rate, (0, TURN_S), start, t_eval=times(TURN_S), rtol=1e-7, atol=1e-9, max_step=0.2).y.T
    return y[:, :3], y[:, 12:] @ inverse.T


def fin_turn(name: str = "remus100", model: VehicleModel | None = None) -> Iterator[Check]:
    """Check path, speed and yaw rate from rest into a steady turn under propeller and rudders."""
    positions, velocities = _turn()
    sim = deep_water(model or load_vehicle(name), density_kg_m3=REMUS_100.water_density_kg_m3)
    sim.rov.set_effort(surge=TURN_SURGE, yaw=TURN_YAW)
    flown = fly(sim, STILL, TURN_S)
    size = float(np.ptp(positions, axis=0).max())
    for k, axis in enumerate("xyz"):
        got_m = flown.positions_m[:, k]
        yield along(
            name, f"turn by rudders: {axis}", positions[:, k], got_m, size, PATH_TOLERANCE, "m", x=flown.times_s
        )
    for what, k, unit in (("speed ahead", 0, "m/s"), ("drift", 1, "m/s"), ("yaw rate", 5, "rad/s")):
        want, got = float(velocities[-1, k]), float(flown.velocities[-1, k])
        yield relative(name, f"steady turn by rudders: {what}", want, got, STEADY_TOLERANCE, unit)


def fin_checks() -> list[Check]:
    """Return all checks."""
    return [*fin_wrenches(), *fin_travel(), *fin_turn()]
