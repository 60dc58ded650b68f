"""A vehicle's commands and motion on common times: what identification and a model beside a log need."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim.base.arrays import Floats
from uwsim.base.axes import AXES
from uwsim.base.named import did_you_mean
from uwsim.base.short_repr import ShortRepr
from uwsim.batch import Batch
from uwsim.recording.real_flights.flight_log import FlightLog, Series
from uwsim.recording.real_flights.frames import FRAMES, frame_of, servo_motors
from uwsim.scenario import VehicleModel
from uwsim.scenario.read.note import Note

GAP_S = 1.0  # measured values are interpolated over shorter gaps only
LEAST_COMMAND, LEAST_TURN_RAD, LEAST_WAY_M = 0.02, 0.02, 0.05
LEAST_ROWS = 20
TILT = ("roll", "pitch")
NEUTRAL_US, SPAN_US = 1500.0, 400.0
"""ArduSub's MOT_PWM_MIN and MOT_PWM_MAX are 1100 and 1900 by default."""
FRAME_NAMES = {1.0: "vectored", 2.0: "vectored_6dof"}
"""ArduSub's FRAME_CONFIG."""
FIRST_MOTOR = 33  # SERVOn_FUNCTION of the first motor
IN_ORDER, EXAMPLE = "order", "such as 1=front_right,2=-front_left"
Motors = dict[str, tuple[int, float]]  # a thruster's output, from 0, and sign
PAIR = re.compile(r"\s*(?P<output>[1-9]\d?)\s*=\s*(?P<sign>-?)(?P<thruster>\S+)\s*")


@dataclass(frozen=True, eq=False, repr=False)
class MotionLog(ShortRepr):
    """A vehicle's commands and motion.

    times_s (n,), increasing; position_m (n, 3), orientation_xyzw (n, 4), velocity_body (n, 6): NaN where not
    measured; effort_times_s (m,), efforts (m, 6): each held until the next. noise: standard deviations of position
    [m], attitude [rad], velocity [m/s] and rate [rad/s], if known. effort_sds_s (m,): standard deviations of the
    commands' times, 0 if these are exact; see sampled(). thrusters: if given, the efforts are commands of these.
    unstated: of roll and pitch, those that nothing measured: 0 in the attitude.
    """

    times_s: Floats
    position_m: Floats
    orientation_xyzw: Floats
    velocity_body: Floats
    effort_times_s: Floats
    efforts: Floats
    noise: dict[str, float]
    effort_sds_s: Floats | float = 0.0
    thrusters: tuple[str, ...] = ()
    unstated: tuple[str, ...] = ()


def command(batch: Batch, thrusters: Sequence[str], efforts: Floats) -> None:
    """Give each member its efforts (members, 6), or its commands (members, k) of thrusters."""
    if thrusters:
        batch.set_thrusters({name: efforts[:, k] for k, name in enumerate(thrusters)})
    else:
        batch.set_effort(np.ascontiguousarray(efforts))


def sampled(times_s: Floats, efforts: Floats) -> tuple[Floats, Floats, Floats]:
    """Return times (m,), efforts (m, k) and deviations (m,) of the changes in efforts that were sampled at times_s."""
    kept = np.flatnonzero(np.diff(efforts, axis=0).any(axis=1)) + 1
    gap_s = times_s[kept] - times_s[kept - 1]
    times = np.concatenate([times_s[:1], times_s[kept] - 0.5 * gap_s])
    return times, efforts[[0, *kept]], np.concatenate([[0.0], gap_s / np.sqrt(12.0)])


def motion_of(log: FlightLog, model: VehicleModel, outputs: str | None = None) -> tuple[MotionLog, list[Note]]:
    """Return a log's motion and the commands of a vehicle's thrusters, and notes on what was assumed.

    outputs: which output drives which thruster: a frame of ArduSub, `order` for the file's order, or pairs such as
    `1=front_right, 2=-front_left`. Raises ValueError for a log without attitude, commands or motion.
    """
    found = log.series
    if "attitude" not in found:
        raise ValueError(f"{log.path}: has no attitude: a model can be compared only with a log that has it")
    commands, names, notes = _commands(log, model, outputs)
    attitude = found["attitude"]
    kept = np.linalg.norm(attitude.values, axis=1) > 0.5  # also false for NaN
    times_s, quaternions = attitude.times_s[kept], attitude.values[kept]
    if len(times_s) < LEAST_ROWS:
        raise ValueError(f"{log.path}: {len(times_s)} rows with an attitude: at least {LEAST_ROWS} are needed")
    quaternions = quaternions / np.linalg.norm(quaternions, axis=1)[:, None]
    position = at_times(found.get("position"), times_s, 3)
    if "depth" in found:
        is_deeper = ~np.isfinite(position[:, 2])
        position[is_deeper, 2] = -at_times(found["depth"], times_s, 1)[is_deeper, 0]
    body = at_times(found.get("body velocity"), times_s, 3)
    if "velocity" in found and "body velocity" not in found:
        body = Rotation.from_quat(quaternions).inv().apply(at_times(found["velocity"], times_s, 3))
    velocity = np.hstack([body, at_times(found.get("rates"), times_s, 3)])
    begin, end = commands.times_s[0], commands.times_s[-1] + GAP_S
    within = (times_s >= begin) & (times_s <= end)
    if within.sum() < LEAST_ROWS:
        raise ValueError(
            f"{log.path}: {within.sum()} rows of attitude from {begin:g} to {end:g} s, when thrusters are"
            f" logged: at least {LEAST_ROWS} are needed"
        )
    starts, efforts, sds = sampled(commands.times_s, commands.values)
    kept = np.flatnonzero(within)
    motion = MotionLog(
        times_s[kept], position[kept], quaternions[kept], velocity[kept], starts, efforts, {}, sds, names, log.unstated
    )
    _require_motion(log, motion)
    return motion, notes


def _require_motion(log: FlightLog, motion: MotionLog) -> None:
    span_s = motion.times_s[-1] - motion.times_s[0]
    needs = "needs a flight: armed, thrusters at work, the vehicle moving"
    if np.abs(motion.efforts).max() < LEAST_COMMAND:
        raise ValueError(f"{log.path}: no motion: the thrusters stay at rest for all of its {span_s:.0f} s: {needs}")
    first = Rotation.from_quat(motion.orientation_xyzw[0]).inv()
    turn_rad = float((first * Rotation.from_quat(motion.orientation_xyzw)).magnitude().max())
    ways_m = [float(np.ptp(axis[np.isfinite(axis)])) for axis in motion.position_m.T if np.isfinite(axis).any()]
    way_m = max(ways_m, default=0.0)
    if turn_rad < LEAST_TURN_RAD and way_m < LEAST_WAY_M:
        raise ValueError(
            f"{log.path}: no motion: in {span_s:.0f} s it turns {np.degrees(turn_rad):.2f} deg and moves "
            f"{way_m:.3f} m: {needs}"
        )


def at_times(series: Series | None, times_s: Floats, width: int) -> Floats:
    """Return values (n, width) at some times, interpolated over short gaps, else NaN."""
    if series is None:
        return np.full((len(times_s), width), np.nan)
    found = np.full((len(times_s), width), np.nan)
    for k in range(width):
        known = np.isfinite(series.values[:, k])
        own_s, values = series.times_s[known], series.values[known, k]
        if len(own_s) < 2:
            continue
        after = np.clip(np.searchsorted(own_s, times_s), 1, len(own_s) - 1)
        near = own_s[after] - own_s[after - 1] <= GAP_S
        found[:, k] = np.where(near, np.interp(times_s, own_s, values, np.nan, np.nan), np.nan)
    return found


def _commands(log: FlightLog, model: VehicleModel, outputs: str | None) -> tuple[Series, tuple[str, ...], list[Note]]:
    """Return the commands, the thrusters that they are of (none for efforts), and notes on what was assumed."""
    found, thrusters = log.series, list(model.thrusters)
    if (efforts := found.get("efforts")) is not None:
        values = np.zeros((len(efforts.times_s), 6))
        for k, axis in enumerate(efforts.names):
            values[:, AXES.index(axis)] = efforts.values[:, k]
        return _checked(log, Series(efforts.times_s, np.nan_to_num(values), efforts.source)), (), []
    if (given := found.get("thrusters")) is not None:
        names, notes = given.names, []
        if not names:
            if given.values.shape[1] < len(thrusters):
                raise ValueError(
                    f"{log.path}: {given.source}: {given.values.shape[1]} commands, but vehicle "
                    f"'{model.name}' has {len(thrusters)} thrusters"
                )
            names = tuple(thrusters)
            notes.append(Note("assumed", f"commands are of the thrusters {', '.join(thrusters)}, in this order"))
        for name in names:
            _require_thruster(f"{log.path}: {given.source}", name, thrusters)
        kept = np.nan_to_num(given.values[:, : len(names)])
        return _checked(log, Series(given.times_s, kept, given.source)), names, notes
    if "outputs" not in found:
        raise ValueError(f"{log.path}: has no outputs of thrusters: needs RCOU, SERVO_OUTPUT_RAW, or commands by name")
    motors, notes = _motors(log, model, outputs)
    series = found["outputs"]
    low, high = (log.parameters.get(f"MOT_PWM_{end}", 0.0) for end in ("MIN", "MAX"))
    span_us = 0.5 * (high - low) if high - low > 1.0 else SPAN_US
    if high - low <= 1.0:
        pulses = f"pulses of {NEUTRAL_US - SPAN_US:g} to {NEUTRAL_US + SPAN_US:g} us"
        notes.append(Note("assumed", f"{pulses} are commands -1 to 1"))
    if max(motors.values(), key=lambda each: each[0])[0] >= series.values.shape[1]:
        count = series.values.shape[1]
        raise ValueError(f"{log.path}: {series.source}: has {count} outputs: too few for {outputs or model.name}")
    columns = [sign * (series.values[:, output] - NEUTRAL_US) / span_us for output, sign in motors.values()]
    values = np.clip(np.nan_to_num(np.column_stack(columns)), -1.0, 1.0)
    return Series(series.times_s, values, series.source), tuple(motors), notes


def _motors(log: FlightLog, model: VehicleModel, outputs: str | None) -> tuple[Motors, list[Note]]:
    """Return the output, from 0, and the sign of each thruster, and notes on what was assumed."""
    thrusters, notes = model.thrusters, list[Note]()
    if outputs is not None and "=" in outputs:
        return _stated(outputs, list(thrusters)), notes
    if outputs == IN_ORDER:
        return {name: (k, 1.0) for k, name in enumerate(thrusters)}, notes
    frame = outputs
    if frame is None:
        stated = log.parameters.get("FRAME_CONFIG")
        if stated is not None and stated not in FRAME_NAMES:
            raise ValueError(f"{log.path}: FRAME_CONFIG = {stated:g}: must be 1 or 2; or state --outputs, {EXAMPLE}")
        frame = frame_of(thrusters, model.name) if stated is None else FRAME_NAMES[stated]
        if stated is None:
            fits = f"ArduSub's frame {frame}, which the vehicle's thrusters fit"
            notes.append(Note("assumed", f"{fits}; no FRAME_CONFIG is logged"))
        else:
            notes.append(Note("known", f"ArduSub's frame {frame} from FRAME_CONFIG = {stated:g}"))
    elif frame not in FRAMES:
        known = (*FRAMES, IN_ORDER)
        raise ValueError(
            f"--outputs {frame}: must be one of {', '.join(known)}, or {EXAMPLE}{did_you_mean(frame, known)}"
        )
    try:
        motors = servo_motors(frame, thrusters, model.name)
    except ValueError as error:
        raise ValueError(f"{log.path}: {error}") from None
    numbers = {int(v) - FIRST_MOTOR: k - 1 for k in range(1, 33) if (v := _function(log.parameters, k)) is not None}
    turned = {k: log.parameters.get(f"MOT_{k + 1}_DIRECTION", 0.0) for k in range(len(motors))}
    if not numbers:
        notes.append(Note("assumed", "motor 1 is output 1, and so on; no SERVOn_FUNCTION is logged"))
    if not any(turned.values()):
        notes.append(Note("assumed", "no motor is reversed; no MOT_n_DIRECTION is logged"))
    signs = {k: -1.0 if value < 0 else 1.0 for k, value in turned.items()}
    return {
        each.thruster: (numbers.get(each.output, each.output), each.direction * signs[each.output]) for each in motors
    }, notes


def _function(parameters: Mapping[str, float], output: int) -> float | None:
    value = parameters.get(f"SERVO{output}_FUNCTION")
    return value if value is not None and FIRST_MOTOR <= value < FIRST_MOTOR + 8 else None


def _stated(outputs: str, thrusters: list[str]) -> Motors:
    found: dict[str, tuple[int, float]] = {}
    for part in outputs.split(","):
        match = PAIR.fullmatch(part)
        if match is None:
            raise ValueError(f"--outputs {part.strip()}: must be OUTPUT=THRUSTER, such as 2=-front_left")
        _require_thruster("--outputs", match["thruster"], thrusters)
        found[match["thruster"]] = int(match["output"]) - 1, -1.0 if match["sign"] else 1.0
    return found


def _require_thruster(where: str, name: str, thrusters: list[str]) -> None:
    if name not in thrusters:
        raise ValueError(
            f"{where}: thruster '{name}': must be one of {', '.join(thrusters)}{did_you_mean(name, thrusters)}"
        )


def _checked(log: FlightLog, series: Series) -> Series:
    if (worst := float(np.abs(series.values).max())) > 1.0:
        raise ValueError(f"{log.path}: {series.source}: a command of {worst:g}: must be in [-1, 1]")
    return series
