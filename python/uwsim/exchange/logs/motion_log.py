"""MotionLog: a vehicle's commands and motion, from a recording, an MCAP file, a ROS bag or a CSV table.

A mapping file states where each quantity is found: in a column of a table, or in a `topic:field` of a message log, such
as `/odom:pose.pose.position.x` or `/telemetry:efforts[0]`.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from uwsim.base.extras import need_extra
from uwsim.base.texts.csv_table import read_csv
from uwsim.base.texts.json_text import json_object
from uwsim.batch.arguments import require_possible
from uwsim.exchange.logs.message_log import COMMANDS, MessageLog
from uwsim.recording.foreign_bag import foreign_bag
from uwsim.recording.real_flights.motion import MotionLog, motion_of, sampled
from uwsim.recording.real_flights.read import read_flight
from uwsim.scenario import VehicleModel
from uwsim.scenario.read.contained import run_contained
from uwsim.scenario.read.note import Note
from uwsim.scenario.read.spec_file import read_yaml
from uwsim.scenario.read.validated import validated
from uwsim.scenario.spec.fields import InRange, Model, broken

Array = NDArray[np.float64]
ODOMETRY = {
    "position_m": [f"{{}}:pose.pose.position.{axis}" for axis in "xyz"],
    "orientation_xyzw": [f"{{}}:pose.pose.orientation.{axis}" for axis in "xyzw"],
    "velocity_body": [f"{{}}:twist.twist.{part}.{axis}" for part in ("linear", "angular") for axis in "xyz"],
}
LEAST_ROWS = 20
MOST_GAP_S = 3600.0


class Mapping(Model):
    """The location of each quantity in a log. World: z up; body: x forward, y left, z up (REP 103).

    time_s: a table's time column [s]. position_m (3), orientation_xyzw (4), velocity_body (6) [m/s, rad/s]:
    measured motion; positions and velocities may be left out. effort (6): commands in [-1, 1], surge to yaw, each held
    until the next one; null for an axis without commands. noise: standard deviations of position [m], attitude [rad],
    velocity [m/s] and rate [rad/s], if known; otherwise estimated from the residuals. effort_is_sampled: whether a
    change of the commands may have happened at any time since the previous row or message, rather than at its own; by
    default in tables only.
    """

    time_s: str | None = None
    position_m: tuple[str, str, str] | None = None
    orientation_xyzw: tuple[str, str, str, str]
    velocity_body: tuple[str, str, str, str, str, str] | None = None
    effort: tuple[str | None, str | None, str | None, str | None, str | None, str | None]
    noise: dict[Literal["position", "attitude", "velocity", "rate"], Annotated[float, InRange(1e-9, 1e3)]] = Field(
        default_factory=dict
    )
    effort_is_sampled: bool | None = None

    @model_validator(mode="after")
    def _has_commands(self) -> Mapping:
        if not any(name is not None for name in self.effort):
            raise broken("must name at least one axis with commands", at=("effort",))
        return self


def read_mapping(path: Path) -> Mapping:
    """Read a mapping file. Raises ValueError with all mistakes, each with its line."""
    document = read_yaml(path, str(path))
    return validated(Mapping, document.values, document)


def read_log(path: str | Path, mapping: Mapping | None = None, vehicle: str = "") -> MotionLog:
    """Read a log. mapping: required unless the file is a uwsim recording. vehicle: prefix of its topics.

    Raises OSError, and ValueError with the file and the quantity.
    """
    path = Path(path)
    if path.suffix.lower() == ".csv":
        if mapping is None or mapping.time_s is None:
            raise ValueError(f"{path}: a table needs a mapping file (--map) with time_s, or --columns")
        return _checked(path, _from_series(mapping, _table(path, mapping), is_sampled=True))
    need_extra("rosbags", f"{path}: a log of messages")
    chosen = None if mapping is None else mapping.model_dump(mode="json")
    made: dict[str, Any] = run_contained(Path(__file__), "rosbags", str(path), chosen, vehicle, reads=[path])
    noise = json_object(made.pop("noise").tobytes(), str(path))
    return _checked(path, MotionLog(**made, noise={name: float(str(value)) for name, value in noise.items()}))


def read(path: str, mapping: dict[str, Any] | None, vehicle: str) -> dict[str, Any]:
    """Return the fields of a log of messages: the script of a contained process."""
    messages = MessageLog(Path(path))
    chosen = own_mapping(messages, vehicle) if mapping is None else Mapping.model_validate(mapping)
    made = dict(vars(_from_series(chosen, messages.series, is_sampled=False)))
    noise = np.frombuffer(json.dumps(made.pop("noise")).encode(), np.uint8)
    return {**{name: each for name, each in made.items() if name not in ("thrusters", "unstated")}, "noise": noise}


def read_flown(
    path: Path, model: VehicleModel, vehicle: str = "", columns: str | None = None, outputs: str | None = None
) -> tuple[MotionLog, list[Note]]:
    """Read a log without a mapping file; return it and notes on what is known, missing and assumed.

    vehicle: prefix of its topics in a recording of uwsim. columns, outputs: see real_flights.columns and
    real_flights.motion. Raises OSError, and ValueError with the file and the rule.
    """
    if columns is None and path.suffix == ".mcap" and foreign_bag(path) is None:
        return read_log(path, None, vehicle), []
    flight = read_flight(path, columns)
    motion, notes = motion_of(flight, model, outputs)
    return motion, [*flight.notes(), *notes]


Series = Callable[[str], tuple[Array, Array]]


def _from_series(mapping: Mapping, series: Series, *, is_sampled: bool) -> MotionLog:
    times_s, _ = series(mapping.orientation_xyzw[0])

    def measured(names: tuple[str, ...] | None, width: int) -> Array:
        if names is None:
            return np.full((len(times_s), width), np.nan)
        columns = []
        for own_times, values in map(series, names):
            is_same = np.array_equal(own_times, times_s)
            columns.append(values if is_same else np.interp(times_s, own_times, values, np.nan, np.nan))
        return np.column_stack(columns)

    given = {k: series(name) for k, name in enumerate(mapping.effort) if name is not None}
    effort_times_s = np.unique(np.concatenate([own_times for own_times, _ in given.values()]))
    efforts = np.zeros((len(effort_times_s), 6))
    for k, (own_times, values) in given.items():
        index = np.searchsorted(own_times, effort_times_s, side="right") - 1
        efforts[:, k] = np.where(index >= 0, values[np.maximum(index, 0)], 0.0)
    position_m, velocity_body = measured(mapping.position_m, 3), measured(mapping.velocity_body, 6)
    orientation_xyzw = measured(mapping.orientation_xyzw, 4)
    noise = {str(key): value for key, value in mapping.noise.items()}
    log = MotionLog(times_s, position_m, orientation_xyzw, velocity_body, effort_times_s, efforts, noise)
    if not (is_sampled if mapping.effort_is_sampled is None else mapping.effort_is_sampled):
        return log
    times, efforts, sds = sampled(effort_times_s, efforts)
    return replace(log, effort_times_s=times, efforts=efforts, effort_sds_s=sds)


def _table(path: Path, mapping: Mapping) -> Series:
    table = read_csv(path)
    times_s = table.numbers(mapping.time_s or "")
    return lambda name: (times_s, table.numbers(name, may_lack=True))


def own_mapping(messages: MessageLog, vehicle: str) -> Mapping:
    """Return the mapping for a uwsim recording: true or estimated odometry, and the efforts.

    These come from the recorded commands if nothing else steered the vehicle, otherwise from the telemetry.
    """
    prefix = f"/{vehicle}" if f"/{vehicle}/telemetry" in messages.topics else ""
    odometry = next((t for t in (f"{prefix}/ground_truth/odom", f"{prefix}/odom") if t in messages.topics), None)
    if odometry is None or f"{prefix}/telemetry" not in messages.topics:
        raise ValueError(f"{messages.path}: no {prefix}/odom and {prefix}/telemetry: name the topics in a mapping file")
    fields: dict[str, Any] = {key: [name.format(odometry) for name in names] for key, names in ODOMETRY.items()}
    has_commands = messages.keep_efforts(vehicle)
    if vehicle and not prefix and messages.commanded and vehicle not in messages.commanded:
        raise ValueError(f"{messages.path}: no vehicle '{vehicle[:40]}': has {', '.join(sorted(messages.commanded))}")
    source = COMMANDS if has_commands else f"{prefix}/telemetry"
    efforts = [f"{source}:efforts[{k}]" for k in range(6)]
    return Mapping.model_validate({**fields, "effort": efforts, "effort_is_sampled": not has_commands})


def _checked(path: Path, log: MotionLog) -> MotionLog:
    """Return the log without rows that lack an attitude. Raises ValueError."""
    norms = np.linalg.norm(log.orientation_xyzw, axis=1)
    kept = (norms > 0.5) & np.isfinite(norms)
    if kept.sum() < LEAST_ROWS:
        raise ValueError(f"{path}: {kept.sum()} rows with an attitude: at least {LEAST_ROWS} are needed")
    times_s = log.times_s[kept]
    gaps_s = np.diff(times_s)
    if not ((gaps_s > 0) & (gaps_s <= MOST_GAP_S)).all():
        at = int(np.argmax(~((gaps_s > 0) & (gaps_s <= MOST_GAP_S))))
        rule = "times must increase" if gaps_s[at] <= 0 else f"must be within {MOST_GAP_S:g} s: cut the log there"
        raise ValueError(f"{path}: time {times_s[at]:.12g} s is followed by {times_s[at + 1]:.12g} s: {rule}")
    if not np.isfinite(log.efforts).all() or np.abs(log.efforts).max() > 1:
        worst = float(log.efforts.ravel()[np.argmax(np.abs(np.nan_to_num(log.efforts, nan=np.inf)))])
        raise ValueError(f"{path}: effort = {worst:g}: must be in [-1, 1]")
    require_possible(path, times_s, log.velocity_body[kept])
    quaternions = log.orientation_xyzw[kept] / norms[kept, None]
    position_m, velocity_body = log.position_m[kept], log.velocity_body[kept]
    return replace(
        log, times_s=times_s, position_m=position_m, orientation_xyzw=quaternions, velocity_body=velocity_body
    )
