"""Identification by output error: least squares between the measured and the simulated motion.

The vehicle is simulated with the log's commands, and its unknowns are changed until the motions agree best (Ljung 1999,
System Identification, ch. 7; Jategaonkar 2006, Flight Vehicle System Identification, ch. 4).

The noise of each output is estimated from the residuals. The prior of each unknown (unknowns.py) enters as one more
observation, so that the solution exists whatever the log contains. Intervals follow from the inverse of the information
matrix at the solution; they assume that the model is right and the noise white. Where residuals are correlated from
sample to sample, the noise's variance is multiplied by (1 + r) / (1 - r), with r their lag-one correlation.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from scipy.optimize import least_squares
from scipy.stats import norm

from uwsim.base.arrays import Floats
from uwsim.base.short_repr import ShortRepr
from uwsim.evidence.identification.flown import OUTPUTS, Block, Flown
from uwsim.evidence.identification.unknowns import Place, Unknown, numbers_at, unknowns
from uwsim.recording.real_flights.deep_water import VEHICLE
from uwsim.recording.real_flights.motion import MotionLog
from uwsim.scenario import VehicleModel
from uwsim.scenario.build.hull import is_boat
from uwsim.scenario.build.vehicle import completed
from uwsim.scenario.spec.fields import Model

NORMAL_95 = float(norm.ppf(0.975))
FIRST_NOISE, LEAST_NOISE = np.repeat((0.05, 0.02, 0.05, 0.05), 3), np.full(12, 1e-4)
GROUPS = ("position", "attitude", "velocity", "rate")
BOUND = 5.0  # standard deviations of the prior
DETERMINED = 0.7
"""The log determines a quantity if it reduces the prior's standard deviation to less than this share."""
ROUNDS = 3
ROUGH, FINE = 1e-3, 1e-6
"""Relative tolerances of the cost, about 1e3: with a guessed noise and with the estimated one."""
BRIEF_S, MOST_BRIEF = 4.0, 60
"""Length of the segments in the first solution, so short that no motion diverges, and their number."""


@dataclass(frozen=True)
class Value:
    """An identified quantity. low, high: ends of its 95 % interval. left: share of the prior's spread that remains.

    places: the numbers in the vehicle's file that it replaces; none for the current and the delay.
    """

    name: str
    unit: str
    before: float
    value: float
    low: float
    high: float
    left: float
    places: tuple[Place, ...] = ()

    @property
    def is_determined(self) -> bool:
        """True if the log determines the value, rather than the prior."""
        return self.left < DETERMINED


@dataclass(frozen=True, eq=False, repr=False)
class Identified(ShortRepr):
    """The result. values: quantities by name. undetermined: combinations, as (share of the spread left, {name: part}).

    residuals (n, 12), NaN where nothing was measured: position [m], attitude [rad], velocity [m/s], rate [rad/s].
    noise (12,): their standard deviations. correlation (12,): at lag one. model: the vehicle, with the values
    that the log determines, given the file's for the others; numbers: the same by place in the file. premises: what
    all values depend on and no log is asked for, or the file does not state: one line each, with its source.
    """

    values: dict[str, Value]
    undetermined: list[tuple[float, dict[str, float]]]
    residuals: Floats
    noise: Floats
    correlation: Floats
    times_s: Floats
    model: VehicleModel
    numbers: dict[Place, float]
    premises: tuple[str, ...]


def identify(
    log: MotionLog,
    model: VehicleModel,
    *,
    spreads: Mapping[str, float] | None = None,
    known: tuple[str, ...] = (),
    segment_s: float = 60.0,
    density_kg_m3: float = 1000.0,
    threads: int | None = None,
) -> Identified:
    """Identify a vehicle's coefficients from a log of its motion, deep under water or, a boat's, at a calm surface.

    model: the vehicle, with the best values known. spreads, known: see unknowns(). segment_s: the log is simulated in
    parts of about this length, each with its own initial state, so that disturbances do not accumulate. Raises
    ValueError if nothing is unknown, or if the vehicle cannot be simulated.
    """
    model, added = completed(model, density_kg_m3)
    found = unknowns(model, VEHICLE, spreads, known, added=added)
    if is_boat(model, density_kg_m3):  # its mesh determines which part is under water
        found = [each for each in found if each.group not in ("volume_m3", "centre_of_buoyancy_m")]
    if not found:
        raise ValueError("known: nothing is left to be identified")
    flown = Flown(model, log, found, segment_s, density_kg_m3, threads)
    given = _given_noise(log)
    scale = np.where(np.isfinite(given), given, FIRST_NOISE)
    brief = Flown(model, log, found, BRIEF_S, density_kg_m3, threads, MOST_BRIEF)
    z = np.zeros(flown.size)
    z[: len(found)] = _solved(brief, np.zeros(brief.size), scale, ROUGH)[: len(found)]
    for k in range(ROUNDS):
        is_guess = k == 0 and np.isnan(given).any()
        z = _solved(flown, z, scale, ROUGH if is_guess else FINE)
        residuals, blocks = flown.outputs(z)
        rms = _rms(residuals)
        before, scale = scale, np.where(np.isfinite(given), given, rms)
        if np.abs(np.log(scale / before)).max() < 0.02:
            break
    correlation = _lag_one(residuals)
    wide = scale * np.sqrt((1 + correlation) / (1 - correlation))
    information = np.zeros((flown.size, flown.size))
    for block in blocks:
        weighted = (block.slopes / wide[:, None])[np.isfinite(residuals[block.rows])]
        information[np.ix_(block.columns, block.columns)] += weighted.T @ weighted
    p = len(found)
    covariance: Floats = np.asarray(np.linalg.inv(information + np.eye(flown.size))[:p, :p], np.float64)
    left: Floats = np.asarray(np.sqrt(np.diag(covariance)), np.float64)
    own = numbers_at(found, np.zeros(p))
    numbers = {place: n for place, n in numbers_at(found, _kept(z[:p], covariance, left)).items() if n != own[place]}
    return Identified(
        _values(found, z, left),
        _undetermined(found, information),
        residuals,
        scale,
        correlation,
        log.times_s,
        reduce(lambda part, at: _with_number(part, at, numbers[at]), numbers, model),
        numbers,
        _premises(model, found, added),
    )


def _premises(model: VehicleModel, found: list[Unknown], added: tuple[str, ...]) -> tuple[str, ...]:
    """Return one line for each property of the body that is held, or that the vehicle's file does not state."""
    groups = {each.group for each in found}
    none = "of the hull's mesh: the vehicle's file states none"
    lines = []
    for key, unit in (("mass_kg", "kg"), ("volume_m3", "m3"), ("centre_of_mass_m", "m"),
                      ("centre_of_buoyancy_m", "m"), ("inertia_kg_m2", "kg m2")):  # fmt: skip
        if key in groups:
            lines += [f"{key}: identified from that {none}"] if key in added else []
            continue
        value = getattr(model, key)
        if value is None:  # a mass
            lines.append("mass_kg: the volume times the density, as the vehicle's file states")
            continue
        source = none if key in added else "as the vehicle's file states"
        shown = " ".join(f"{part:.4g}" for part in np.atleast_1d(value))
        lines.append(f"{key} = {shown} {unit}: held, {source}")
    return tuple(lines)


def _solved(flown: Flown, z: Floats, scale: Floats, tolerance: float) -> Floats:
    """Return the solution for this noise, starting at z. tolerance: relative change of the cost at which to stop."""
    cache: dict[bytes, tuple[Floats, Floats]] = {}

    def both(at: Floats) -> tuple[Floats, Floats]:
        key = at.tobytes()
        if key not in cache:
            cache.clear()
            try:
                residuals, blocks = flown.outputs(at)
            except ValueError:
                if not last:
                    raise
                cache[key] = np.full_like(last[0][0], 1e6), last[0][1]  # the step was too long; the solver retracts it
                return cache[key]
            cache[key] = _compressed(residuals, blocks, scale, at, len(flown.found))
            last[:] = [cache[key]]
        return cache[key]

    last: list[tuple[Floats, Floats]] = []
    found: Any = least_squares(
        lambda at: both(at)[0],
        z,
        lambda at: both(at)[1],
        bounds=(-BOUND, BOUND),
        xtol=1e-6,
        ftol=tolerance,
        max_nfev=40,
    )
    return np.asarray(found.x, np.float64)


def _compressed(residuals: Floats, blocks: list[Block], scale: Floats, z: Floats, p: int) -> tuple[Floats, Floats]:
    """Return fewer rows with the same sums of squares and products, and the prior's, by QR: first of each segment.

    p: the number of unknowns that concern all segments.
    """
    misfits, slopes, shared = [], [], [np.column_stack([np.eye(p), z[:p]])]
    for block in blocks:
        own = block.columns[p:]
        rows = np.isfinite(residuals[block.rows])
        each = (block.slopes / scale[:, None])[rows]
        found = np.column_stack([each[:, p:], each[:, :p], (residuals[block.rows] / scale)[rows]])
        prior = np.column_stack([np.eye(len(own)), np.zeros((len(own), p)), z[own]])
        triangle: Floats = np.asarray(np.linalg.qr(np.vstack([found, prior]), "r"), np.float64)
        kept = np.zeros((len(own), len(z)))
        kept[:, own], kept[:, :p] = triangle[: len(own), : len(own)], triangle[: len(own), len(own) : -1]
        slopes.append(kept)
        misfits.append(triangle[: len(own), -1])
        shared.append(triangle[len(own) :, len(own) :])
    triangle = np.asarray(np.linalg.qr(np.vstack(shared), "r"), np.float64)
    slopes.append(np.pad(triangle[:, :-1], ((0, 0), (0, len(z) - p))))
    return np.concatenate([*misfits, triangle[:, -1]]), np.vstack(slopes)


def _given_noise(log: MotionLog) -> Floats:
    for key, value in log.noise.items():
        if key not in GROUPS or not (np.isfinite(value) and value > 0):
            raise ValueError(f"noise.{key} = {value}: must be positive, for one of {', '.join(GROUPS)}")
    return np.repeat([log.noise.get(group, np.nan) for group in GROUPS], 3)


def _rms(residuals: Floats) -> Floats:
    counts = np.isfinite(residuals).sum(axis=0)
    sums = np.nansum(residuals**2, axis=0)
    return np.where(counts > 0, np.maximum(np.sqrt(sums / np.maximum(counts, 1)), LEAST_NOISE), 1.0)


def _lag_one(residuals: Floats) -> Floats:
    """Return the correlations (12,) between successive residuals, from 0 to 0.95."""
    found = np.zeros(OUTPUTS)
    for k in range(OUTPUTS):
        column = residuals[np.isfinite(residuals[:, k]), k]
        if len(column) > 2 and column.std() > 0:
            found[k] = np.corrcoef(column[:-1], column[1:])[0, 1]
    noise = 3.0 / np.sqrt(max(len(residuals), 1))  # white noise may reach this by chance
    return np.where(found > noise, np.minimum(found, 0.95), 0.0)


def _values(found: list[Unknown], z: Floats, spread: Floats) -> dict[str, Value]:
    values = {}
    for unknown, at, sd in zip(found, z, spread, strict=False):
        ends = (unknown.at(at - NORMAL_95 * sd), unknown.at(at + NORMAL_95 * sd))
        values[unknown.name] = Value(
            unknown.name, unknown.unit, unknown.value, unknown.at(at), *ends, float(sd), unknown.places
        )
    return values


def _undetermined(found: list[Unknown], information: Floats) -> list[tuple[float, dict[str, float]]]:
    """Return the directions in which the log contributes less than the prior, with the starts eliminated."""
    p = len(found)
    starts = information[p:, p:] + np.eye(len(information) - p)
    own = information[:p, :p] - information[:p, p:] @ np.linalg.solve(starts, information[p:, :p])
    strengths, directions = np.linalg.eigh(0.5 * (own + own.T))
    undetermined = []
    for strength, direction in zip(strengths, directions.T, strict=True):
        left = float(1.0 / np.sqrt(1.0 + max(strength, 0.0)))
        if left >= DETERMINED:
            order = np.argsort(-np.abs(direction))
            parts = {found[k].name: float(direction[k]) for k in order if abs(direction[k]) >= 0.2}
            undetermined.append((left, parts))
    return undetermined


def _kept(z: Floats, covariance: Floats, left: Floats) -> Floats:
    """Return z (p,) with the quantities that the log does not determine at the file's values.

    The others are the most likely ones given that (the mean of a conditional normal distribution).
    """
    held = left >= DETERMINED
    kept = np.where(held, 0.0, z)
    if held.any() and not held.all():
        across, own = covariance[np.ix_(~held, held)], covariance[np.ix_(held, held)]
        kept[~held] -= across @ np.linalg.solve(own, z[held])
    return kept


def _with_number(part: Any, place: Place, number: float) -> Any:
    """Return a copy of a model, or of a part of one, with a number at a place."""
    if not place:
        return number
    key, rest = place[0], place[1:]
    if isinstance(part, Model):
        return part.model_copy(update={str(key): _with_number(getattr(part, str(key)), rest, number)})
    if isinstance(part, Mapping):
        return {**part, key: _with_number(part[key], rest, number)}
    items = list(part)
    items[int(key)] = _with_number(items[int(key)], rest, number)
    return tuple(items)
