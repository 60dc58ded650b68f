"""The surface of a pipeline with joints, anodes, damage, spans and burial: rings of varying radius along an axis."""

from __future__ import annotations

from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from uwsim.scenario.build.solids import SIDES
from uwsim.scenario.spec.pipe_condition import FeatureKind, PipeCondition, PipeFeature

# Sizes assumed, of a small pipe with a coating of concrete; they scale with the radius where it is small.
JOINT_M, JOINT_DEEP = 0.30, 0.06
"""Length of a field joint, where the coating ends, and its depth in radii."""
ANODE_M, ANODE_HIGH = 0.50, 0.12
DAMAGE_DEEP, DAMAGE_HALF_RAD = 0.12, 0.9
LEAK_HALF_RAD = 0.4
STEP_M = 0.5
COVER_M = 0.1
"""Height of the bed above the top of a buried pipe."""
COATING, JOINT, ANODE, RUST = (0.30, 0.29, 0.27), (0.10, 0.10, 0.11), (0.55, 0.55, 0.57), (0.22, 0.07, 0.02)
DEBRIS = (0.16, 0.15, 0.13)

Floats = NDArray[np.float64]


class Rings(NamedTuple):
    """A pipe's rings: distances along it (n,), height above the usual axis, and by ring and side radius and albedo.

    At each end of a joint, an anode or a damage there are two rings a millimetre apart, so that edges are sharp.
    """

    along_m: Floats
    lift_m: Floats
    radius_m: Floats
    albedo: Floats


def all_features(condition: PipeCondition, length_m: float) -> list[PipeFeature]:
    """Return the features on a pipeline of a length: the given ones that are on it, then those of the seed.

    Raises ValueError if a given one is beyond its end, or if there is no room.
    """
    found = list(condition.features)
    for one in found:
        if one.at_m > length_m:
            raise ValueError(f"a feature is at {one.at_m:g} m: must be at most {length_m:.4g} m, the pipe's length")
    random = np.random.default_rng([condition.seed, 0x70697065])
    wanted: list[FeatureKind] = []
    counts = {"span": condition.spans, "burial": condition.burials, "damage": condition.damages}
    for name, count in {**counts, "debris": condition.debris or 0, "leak": condition.leaks or 0}.items():
        wanted += [cast("FeatureKind", name)] * count
    for kind in wanted:
        for _ in range(500):
            new = PipeFeature(
                kind=kind, at_m=float(random.uniform(0, length_m)), clock_h=float(random.uniform(9, 15)) % 12
            )
            half = new.extent_m / 2
            free = all(abs(new.at_m - one.at_m) > half + one.extent_m / 2 for one in found)
            if half <= new.at_m <= length_m - half and free:
                found.append(new)
                break
        else:
            raise ValueError(f"no room for another {kind} on {length_m:.4g} m: must be fewer")
    return found


def pipe_rings(condition: PipeCondition, length_m: float, corners_m: Floats, radius_m: float, buried_m: float) -> Rings:
    """Return a pipe's rings. corners_m (k,): distances of the line's corners. buried_m: how deep it lies in the bed."""
    features = all_features(condition, length_m)
    joints = joints_m(condition, length_m)
    anodes = anodes_m(condition, length_m)
    bands = [(at - JOINT_M / 2, at + JOINT_M / 2) for at in joints] + [
        (at - ANODE_M / 2, at + ANODE_M / 2) for at in anodes
    ]
    bands += [_ends(one) for one in features if one.kind in ("damage", "leak")]
    edges = np.array(bands).reshape(-1, 2).ravel()
    evenly = np.linspace(0, length_m, max(int(np.ceil(length_m / STEP_M)), 1) + 1)
    along = np.concatenate([evenly, corners_m, edges - 5e-4, edges + 5e-4])
    along = np.unique(np.clip(along, 0, length_m))
    along = along[np.concatenate([[True], np.diff(along) > 2e-4])]
    radius = np.full((len(along), SIDES), radius_m)
    albedo = np.broadcast_to(np.array(COATING), (len(along), SIDES, 3)).copy()
    for places, size, high, colour in ((joints, JOINT_M, -JOINT_DEEP, JOINT), (anodes, ANODE_M, ANODE_HIGH, ANODE)):
        for at in places:
            on = np.abs(along - at) <= size / 2
            radius[on] = radius_m * (1 + high)
            albedo[on] = colour
    lift = np.zeros(len(along))
    for one in features:
        start, end = _ends(one)
        on = (along >= start) & (along <= end)
        if one.kind == "damage":
            sides = np.abs(np.angle(np.exp(1j * (side_angles() - clock_angle(one.clock_h))))) < DAMAGE_HALF_RAD
            radius[np.ix_(on, sides)] = radius_m * (1 - DAMAGE_DEEP)
            albedo[np.ix_(on, sides)] = RUST
        if one.kind == "leak":
            sides = np.abs(np.angle(np.exp(1j * (side_angles() - clock_angle(one.clock_h))))) < LEAK_HALF_RAD
            albedo[np.ix_(on, sides)] = RUST
        if one.kind in ("damage", "debris", "leak"):
            continue
        swell = np.sin(np.pi * (along - start) / (end - start)) ** 2
        deep_m = 2 * radius_m - buried_m + COVER_M
        lift += np.where(on, swell * (one.height_m if one.kind == "span" else -deep_m), 0.0)
    return Rings(along, lift, radius, albedo)


def joints_m(condition: PipeCondition, length_m: float) -> Floats:
    """Return the distances of the field joints along a pipe."""
    return np.arange(condition.joint_m, length_m, condition.joint_m)


def anodes_m(condition: PipeCondition, length_m: float) -> Floats:
    """Return the distances of the anodes along a pipe: by default in the middle of every other length."""
    return np.arange(condition.anode_m / 4, length_m, condition.anode_m)


def side_angles() -> Floats:
    """Return the angle (SIDES,) of each side about the axis: 0 to the left seen along the line, 90 degrees on top."""
    return np.linspace(0, 2 * np.pi, SIDES, endpoint=False)


def clock_angle(clock_h: float) -> float:
    """Return the angle of an hour: 12 is on top, 3 to the right seen along the line."""
    return float(np.pi / 2 + 2 * np.pi * clock_h / 12)


def triangle_albedos(albedo: Floats) -> Floats:
    """Return the albedos (m, 3) of the triangles of a tube whose rings have these (n, SIDES, 3), ends last."""
    wall = np.repeat(albedo[:-1].reshape(-1, 3), 2, axis=0)
    return np.vstack([wall, albedo[0], albedo[-1]])


def _ends(one: PipeFeature) -> tuple[float, float]:
    return one.at_m - one.extent_m / 2, one.at_m + one.extent_m / 2
