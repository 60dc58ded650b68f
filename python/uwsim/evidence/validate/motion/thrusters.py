"""Checks the thrusters of the packaged vehicles, each on its own, against their published values and law."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from uwsim.evidence.validate.check import Check, relative, within
from uwsim.evidence.validate.flights import deep_water, fly
from uwsim.evidence.validate.motion.actuator_probe import LEVEL, STEP_S, STILL, WRENCH_TOLERANCE, Probe, wrench_checks
from uwsim.evidence.validate.motion.published import BLUEROV2_HEAVY
from uwsim.evidence.validate.motion.published_thrusters import MOUNTS, T200
from uwsim.scenario import VehicleModel, load_vehicle

NOSE_DOWN = (0.0, np.sqrt(0.5), 0.0, np.sqrt(0.5))
HEIGHT_TOLERANCE = 5e-3


def thrust_tables(name: str, model: VehicleModel | None = None, points: slice = slice(None)) -> Iterator[Check]:
    """Check the table points, zero thrust in the dead band, and half the thrust halfway to the adjacent points.

    points: the slice of all points to check, in ascending order of command.
    """
    probe, (thruster, mount) = Probe(name, model), next(iter(MOUNTS[name].items()))
    commands, thrusts = np.array(mount.propeller.table).T
    middles = 0.5 * (commands[1:] + commands[:-1])
    beside_dead_band = middles[(thrusts[1:] == 0) | (thrusts[:-1] == 0)]
    for command in np.sort(np.concatenate([commands, beside_dead_band]))[points]:
        probe.command({thruster: float(command)}, mount.propeller)
        got, expected = probe.rov.thrusters[thruster].thrust_n, float(np.interp(command, commands, thrusts))
        label = f"thrust at command {command:.4g}"
        if expected:
            yield relative(name, label, expected, got, 5e-3, "N")  # the propeller table is rounded to 0.01 N
        else:
            yield within(name, label, 0.0, got, 1.0, 1e-4, "N")


def thruster_wrenches(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """Check each thruster on its own at rest, full ahead and full astern: force, moment r x F and reaction torque."""
    probe = Probe(name, model)
    for thruster, mount in MOUNTS[name].items():
        expected, got = [], []
        for command, thrust_n in (mount.propeller.table[-1], mount.propeller.table[0]):
            probe.command({thruster: command}, mount.propeller)
            expected.append(mount.wrench(thrust_n))
            got.append(probe.wrench())
        yield from wrench_checks(name, thruster, np.array(expected), np.array(got))
        # r x F has no component along the axis.
        torque, found = (float(wrenches[0][3:] @ mount.unit) for wrenches in (expected, got))
        yield relative(name, f"{thruster}: reaction torque", torque, found, WRENCH_TOLERANCE, "N m")


def thruster_heights(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """Check a thruster's position along its axis, which affects no moment, by where it emerges from the water."""
    probe = Probe(name, model)
    for thruster, mount in MOUNTS[name].items():
        upright = abs(mount.unit[2]) == 1
        if not upright and abs(mount.unit[0]) != 1:
            continue
        probe.command({thruster: 1.0}, mount.propeller)
        height_m = mount.position_m[2] if upright else -mount.position_m[0]
        axis, attitude = (2, LEVEL) if upright else (0, NOSE_DOWN)
        wet, dry = -height_m - 0.05, -height_m + 0.05
        while dry - wet > 1e-5:
            middle = 0.5 * (wet + dry)
            works = abs(probe.wrench(at_m=(0.0, 0.0, middle), attitude_xyzw=attitude)[axis]) > 1e-3
            wet, dry = (middle, dry) if works else (wet, middle)
        yield relative(name, f"{thruster}: height of the hub", height_m, -0.5 * (wet + dry), HEIGHT_TOLERANCE, "m")


def thruster_lag(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """Check that thrust reaches 63.2 % after one time constant, from rest to full command."""
    probe = Probe(name, model)
    thruster, mount = next(iter(MOUNTS[name].items()))
    command, full_n = mount.propeller.table[-1]
    probe.rov.set_thrusters({thruster: command})
    probe.run(mount.propeller.time_constant_s - STEP_S)
    steps = [
        float(probe.wrench()[:3] @ mount.unit) / full_n for _ in range(2)
    ]  # means over the steps before and after that time
    yield relative(name, f"{thruster}: share of thrust after a time constant", 1 - np.exp(-1), 0.5 * sum(steps), 1e-3)


def advance_loss(name: str, model: VehicleModel | None = None) -> Iterator[Check]:
    """Check the thrust lost to inflow as the vehicle moves and turns; the wrench without thrust is subtracted."""
    probe = Probe(name, model)
    velocity = np.array([1.2, -0.4, 0.3, 0.2, -0.3, 0.4])
    idle = probe.wrench(velocity)  # the fin lift
    for thruster, mount in list(MOUNTS[name].items())[::3]:
        command, still_n = mount.propeller.table[-1]
        probe.command({thruster: command}, mount.propeller)
        thrust_n = mount.propeller.thrust_n(still_n, mount.inflow_m_s(velocity), probe.body.water_density_kg_m3)
        got = float((probe.wrench(velocity) - idle)[:3] @ mount.unit)
        yield relative(name, f"{thruster}: thrust lost to inflow", still_n - thrust_n, still_n - got, 5e-3, "N")


def driven_terminal_speed(name: str = "bluerov2_heavy", model: VehicleModel | None = None) -> Iterator[Check]:
    """Check that BlueROV2 Heavy's thrust, less the loss to inflow, equals its drag at terminal speed ahead and up.

    The horizontal thrusters push at 45 degrees. Full effort ahead is 39.9 N from each front thruster and 51.5 N from
    each rear thruster; efforts up to 0.87 of that are shared evenly. The vertical thrusters deliver 51.5 N each.
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
    """Return all checks; the standard BlueROV2 vehicles have the T200 thruster, which is checked on BlueROV2 Heavy."""
    checks = [c for name in MOUNTS for law in (thruster_wrenches, thruster_heights) for c in law(name)]
    for name in ("bluerov2_heavy", "remus100"):
        checks += [c for law in (thrust_tables, thruster_lag, advance_loss) for c in law(name)]
    return [*checks, *driven_terminal_speed()]
