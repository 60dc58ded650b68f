"""Trials in deep, still water, of a boat on it: a straight run, terminal speeds on each axis, turning circles."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.quaternions import heading_rad
from uwsim.batch.batch import Batch
from uwsim.evidence.validate.flights import deep_scenario
from uwsim.evidence.vehicle.afloat import afloat
from uwsim.evidence.vehicle.linear_motion import mass_matrix
from uwsim.exchange.hulls.draft import SLIP_M_S
from uwsim.scenario import Scenario, VehicleModel
from uwsim.scenario.spec.vehicle import Trim
from uwsim.simulator.simulator import Simulator

TOWED_M, FREE_M = -100.0, -500.0
"""Depths of the trials; a hull in free flight may climb or dive far."""
HOLD_S, LONGEST_S, SETTLED = 0.02, 600.0, 3e-4
"""A towed vehicle is straightened every HOLD_S. A trial ends when no speed will change by more than SETTLED."""
CIRCLE_S, LAST_S, SAMPLE_S = 120.0, 40.0, 0.1
RUN_S, RUN_LAST_S = 30.0, 10.0
TILT_DEG = 15.0
"""Tilt on a straight run beyond which a warning is given; propeller torques roll sound vehicles by up to 12 degrees."""
SLIP_LONGEST_S = 120.0
STEADY, FASTEST = 0.05, 99.0  # FASTEST [m/s, rad/s]: a vehicle can be placed with up to 100


@dataclass(frozen=True)
class StraightRun:
    """RUN_S at full surge effort from rest, level, without control: the motion at its end.

    speed_m_s: along the body's x. heading_change_deg: positive to port. climb_m: change of depth, positive upwards.
    tilt_deg: largest angle between the body's z and the vertical in the last RUN_LAST_S, after the propellers' start.
    tilt_without_munk_deg: the same with munk_share 0; None if the tilt is below TILT_DEG.
    """

    speed_m_s: float
    nose_down_deg: float
    roll_to_starboard_deg: float
    heading_change_deg: float
    climb_m: float
    tilt_deg: float
    tilt_without_munk_deg: float | None = None


@dataclass(frozen=True, eq=False)
class TurningCircle:
    """A turn with constant efforts from rest, without control.

    surge: its effort; the yaw effort is 1, to port. radius_m, speed_m_s, turn_rad_s: means over the last LAST_S of
    CIRCLE_S. is_steady: whether the speed differs by less than STEADY between the halves of LAST_S. climb_m: change of
    depth over CIRCLE_S, positive upwards. tilt_deg: largest angle between the body's z and the vertical. track_m: (n,
    2), x and y from the start.
    """

    surge: float
    radius_m: float
    speed_m_s: float
    turn_rad_s: float
    is_steady: bool
    climb_m: float
    tilt_deg: float
    track_m: Floats


def trial_m(sim: Simulator, deep_m: float) -> float:
    """Return the height at which a trial starts: that of a boat as it floats, else deep_m."""
    is_boat = sim.scenario.vehicles[0].model.coefficients == "afloat"
    return -afloat(sim).water_z_m if is_boat else deep_m


def straight_run(model: VehicleModel, density_kg_m3: float, trim: Trim | None) -> StraightRun:
    """Return a vehicle's straight run. If it tilts, it runs again without Munk moment, to find out what tilts it.

    Raises ValueError if its motion diverges.
    """
    found = _straight_run(model, density_kg_m3, trim)
    if found.tilt_deg <= TILT_DEG:
        return found
    without = _straight_run(model.model_copy(update={"munk_share": 0.0}), density_kg_m3, trim)
    return replace(found, tilt_without_munk_deg=without.tilt_deg)


def _straight_run(model: VehicleModel, density_kg_m3: float, trim: Trim | None) -> StraightRun:
    sim = _deep(model, density_kg_m3, trim)
    rov = sim.rov
    start_m = trial_m(sim, FREE_M)
    rov.place((0.0, 0.0, start_m))
    rov.set_effort(surge=1.0)
    turns = [rov.pose.world_from_body[:3, :3]]
    for _ in range(round(RUN_S / SAMPLE_S)):
        sim.advance(SAMPLE_S)
        turns.append(rov.pose.world_from_body[:3, :3])
    attitudes = np.array(turns)
    headings = np.unwrap(np.arctan2(attitudes[:, 1, 0], attitudes[:, 0, 0]))
    ahead, aside, up = attitudes[-1, 2]
    tilts = np.arccos(np.clip(attitudes[-round(RUN_LAST_S / SAMPLE_S) :, 2, 2], -1.0, 1.0))
    return StraightRun(
        speed_m_s=float(rov.velocity.linear_body_m_s[0]),
        nose_down_deg=float(-np.degrees(np.arcsin(np.clip(ahead, -1.0, 1.0)))) + 0.0,
        roll_to_starboard_deg=float(np.degrees(np.arctan2(aside, up))),
        heading_change_deg=float(np.degrees(headings[-1] - headings[0])),
        climb_m=float(rov.pose.position_world_m[2] - start_m),
        tilt_deg=float(np.degrees(tilts.max())),
    )


def _deep(model: VehicleModel, density_kg_m3: float, trim: Trim | None) -> Simulator:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # the check's own simulator gave them
        return Simulator(deep_scenario(model, density_kg_m3=density_kg_m3, trim=trim))


@dataclass(frozen=True)
class Slip:
    """A motion to the side without surge and without control, SLIP_M_S at first, until it has fallen to half."""

    time_s: float
    distance_m: float


def slip(model: VehicleModel, density_kg_m3: float, trim: Trim | None) -> Slip:
    """Return how a vehicle's side slip dies down in deep, still water; after at most SLIP_LONGEST_S."""
    sim = _deep(model, density_kg_m3, trim)
    rov = sim.rov
    rov.place((0.0, 0.0, TOWED_M), velocity_body=(0.0, SLIP_M_S, 0.0, 0.0, 0.0, 0.0))
    while rov.velocity.linear_body_m_s[1] > 0.5 * SLIP_M_S and sim.time_s < SLIP_LONGEST_S:
        sim.advance(SAMPLE_S)
    return Slip(sim.time_s, float(np.linalg.norm(rov.pose.position_world_m[:2])))


def terminal_speeds(scenario: Scenario) -> Floats:
    """Return the speeds (6, 2) [m/s, rad/s] at full effort ahead and astern on each axis alone.

    NaN on axes without an actuator that works at rest, such as those driven only by fins. Raises ValueError if a speed
    exceeds FASTEST.

    As in a towing tank, only the motion on that axis is free; the others are held at zero and the attitude level. A
    vehicle that would pitch or turn at full effort therefore still has a speed. Thrust falls with speed as in any
    flight. What holds the other axes changes the momentum along them alone, so of a free step from rest across them,
    which changes the velocity by dv, the momentum M dv along the axis remains, and with it the speed M[axis] dv /
    M[axis, axis], where M contains the added mass. For a thrust below the centre of mass that differs from dv[axis].
    """
    batch = Batch(scenario, n=12)
    full = np.max(batch.simulator(0).rov.full_wrench_body, axis=0)
    efforts = np.concatenate([np.eye(6), -np.eye(6)])
    entry = scenario.vehicles[0]
    density_kg_m3 = float(batch.simulator(0).world.water.density_at_kg_m3(0.0))
    kept = mass_matrix(entry.model, entry.trim or entry.model.trim, density_kg_m3)
    kept = np.concatenate([kept / np.diagonal(kept)[:, None]] * 2)
    free = np.abs(efforts)
    velocity = np.zeros((12, 6))
    place = np.array([0.0, 0.0, trial_m(batch.simulator(0), TOWED_M)])
    batch.place(place)
    steps = max(1, round(HOLD_S / scenario.step_s))
    second = round(1.0 / (steps * scenario.step_s))
    before, gains = np.zeros(12), np.full(12, np.inf)
    for k in range(round(LONGEST_S / (steps * scenario.step_s))):
        batch.step(steps, efforts)
        motion = batch.observe()
        gained = np.einsum("ij,ij->i", kept, motion.velocity_body - velocity)
        velocity = velocity + free * gained[:, None]
        if np.abs(velocity).max() > FASTEST:
            axis = AXES[np.abs(velocity).max(axis=0).argmax()]
            rule = f"drives it beyond {FASTEST:g} m/s or rad/s: its thrust is too large, or its drag too small"
            raise ValueError(f"vehicle '{entry.model.name}': full effort on {axis} {rule}")
        batch.place(place, velocity_body=velocity)
        if k % second == 0:
            speeds = np.abs(velocity).sum(axis=1)
            to_come = _to_come(speeds - before, gains)
            if k > 3 * second and np.all(to_come <= SETTLED * np.maximum(speeds, 1e-3)):
                break
            before, gains = speeds, speeds - before
    speeds = np.ascontiguousarray(np.abs(velocity).sum(axis=1).reshape(2, 6).T)
    speeds[full == 0.0] = np.nan
    return np.asarray(speeds)


def _to_come(gained: Floats, before: Floats) -> Floats:
    """Return how much is still to come of what was gained in the last two seconds, if the ratio stays as it is.

    Speeds under quadratic drag approach their limit like tanh(t / tau), in the end by a constant ratio a second.
    """
    ratio = np.abs(gained) / np.maximum(np.abs(before), 1e-300)
    with np.errstate(divide="ignore", invalid="ignore"):
        to_come = np.abs(gained) * ratio / (1 - ratio)
    return np.where(np.abs(gained) < 1e-9, 0.0, np.where(ratio < 1, to_come, np.inf))


def turning_circles(scenario: Scenario, surges: tuple[float, ...] = (0.5, 1.0)) -> tuple[TurningCircle, ...]:
    """Return the turning circles at full yaw and the given surge efforts; none unless surge and yaw are driven."""
    batch = Batch(scenario, n=len(surges))
    if not {"surge", "yaw"} <= batch.simulator(0).rov.controllable:
        return ()
    efforts = np.array([[surge, 0.0, 0.0, 0.0, 0.0, 1.0] for surge in surges])
    start_m = trial_m(batch.simulator(0), FREE_M)
    batch.place((0.0, 0.0, start_m))
    steps = round(SAMPLE_S / scenario.step_s)
    positions, turns = [], []
    for _ in range(round(CIRCLE_S / (steps * scenario.step_s))):
        batch.step(steps, efforts)
        motion = batch.observe()
        positions.append(motion.position_world_m.copy())
        turns.append(motion.orientation_xyzw.copy())
    return tuple(
        _circle(surge, np.array(positions)[:, k], np.array(turns)[:, k], steps * scenario.step_s, start_m)
        for k, surge in enumerate(surges)
    )


def _circle(
    surge: float, positions_m: Floats, orientations_xyzw: Floats, sample_s: float, start_m: float
) -> TurningCircle:
    last = round(LAST_S / sample_s)
    headings = np.unwrap([heading_rad(turn) for turn in orientations_xyzw])
    speeds = np.linalg.norm(np.diff(positions_m[:, :2], axis=0), axis=1)[-last:] / sample_s
    speed, turn = float(speeds.mean()), float(headings[-1] - headings[-1 - last]) / (last * sample_s)
    halves = speeds[: last // 2].mean(), speeds[last // 2 :].mean()
    x, y = orientations_xyzw.T[:2]
    return TurningCircle(
        surge=surge,
        radius_m=speed / abs(turn) if turn else float("inf"),
        speed_m_s=speed,
        turn_rad_s=turn,
        is_steady=bool(abs(halves[1] - halves[0]) <= STEADY * max(speed, 1e-3)),
        climb_m=float(positions_m[-1, 2] - start_m),
        tilt_deg=float(np.degrees(np.arccos(np.clip(1.0 - 2.0 * (x * x + y * y), -1.0, 1.0))).max()),
        track_m=positions_m[:, :2],
    )
