"""The arrivals of sound between two points of a scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.instruments.acoustics.layered_water import Arrivals, arrivals
from uwsim.scenario import Scenario
from uwsim.scenario.build.world import build_world

LEAST_1_S = 1e-7  # weaker gradients are treated as this one, an arc of 1e10 m
STEEPEST_RAD = 0.5 * math.pi - 1e-9
POINTS_PER_ARC = 8
MOST_ARCS = 20_000


def ray_path(
    profile: ArrayLike, bottom_depth_m: float, source_depth_m: float, launch_rad: float, range_m: float
) -> NDArray[np.float64]:
    """Return points (n, 2) of distance and depth [m] along a ray, from its source to a distance.

    profile: as for arrivals(). bottom_depth_m: where rays reflect; may be infinite. launch_rad: below the horizontal.
    By Snell's law, cos(dip) / c = p: in a layer whose speed of sound has the gradient g, the distance grows by
    (sin dip - sin dip') / (p g) and the depth by (cos dip' - cos dip) / (p g) between two dips.
    """
    depths_m, speeds_m_s = _levels(np.asarray(profile, float), bottom_depth_m, source_depth_m)
    dip = float(np.clip(launch_rad, -STEEPEST_RAD, STEEPEST_RAD))
    k = int(np.searchsorted(depths_m, source_depth_m, "right" if dip > 0 else "left")) - 1
    k = min(max(k, 0), len(depths_m) - 2)
    p = math.cos(dip) / float(np.interp(source_depth_m, depths_m, speeds_m_s))
    points = [(0.0, source_depth_m)]
    for _ in range(MOST_ARCS):
        (x, depth), edge = points[-1], k + 1 if dip > 0 else k
        gradient = (speeds_m_s[k + 1] - speeds_m_s[k]) / (depths_m[k + 1] - depths_m[k])
        bend = p * math.copysign(max(abs(gradient), LEAST_1_S), gradient)
        turns = p * speeds_m_s[edge] >= 1.0
        at_edge = -dip if turns else math.copysign(math.acos(p * speeds_m_s[edge]), dip)
        if abs(gradient) < LEAST_1_S:
            at_edge = math.copysign(math.acos(min(1.0, math.cos(dip) + bend * (depths_m[edge] - depth))), dip)
        at_range = math.sin(dip) - bend * (range_m - x)
        ends = abs(at_range) <= 1.0 and (math.sin(dip) - math.sin(at_edge)) / bend >= range_m - x
        end = math.asin(at_range) if ends else at_edge
        dips = np.linspace(dip, end, POINTS_PER_ARC + 1)[1:]
        across = x + (math.sin(dip) - np.sin(dips)) / bend
        lower = depth + (np.cos(dips) - math.cos(dip)) / bend
        points += zip(across.tolist(), lower.tolist(), strict=True)
        if ends:
            break
        dip = end
        if turns:
            continue
        points[-1] = (points[-1][0], depths_m[edge])
        if edge in (0, len(depths_m) - 1):
            dip = -dip
        else:
            k = edge if dip > 0 else edge - 1
    return np.array(points)


def _levels(
    profile: NDArray[np.float64], bottom_depth_m: float, source_depth_m: float
) -> tuple[list[float], list[float]]:
    """Return depths and speeds from the surface to the bottom, or to far below all levels."""
    last = bottom_depth_m if math.isfinite(bottom_depth_m) else max(float(profile[-1, 0]), source_depth_m) + 1e6
    inner = profile[(profile[:, 0] > 0.0) & (profile[:, 0] < last), 0]
    depths_m = [0.0, *inner.tolist(), last]
    return depths_m, np.interp(depths_m, profile[:, 0], profile[:, 1]).tolist()


FLAT = 0.05
"""Largest departure of a flat bed, as a share of the water's depth; as in the rule that blocks a link's rays."""
BED_POINTS = 65
LEVELS = 513

Point = tuple[float, float, float]


@dataclass(frozen=True)
class RaysBetween:
    """The arrivals between two points, and the water through which they travel.

    profile: pairs of depth and speed of sound. bed_m: pairs of distance from the source and depth of the bed; NaN where
    it is unknown. bottom_depth_m: depth of the flat bottom that reflects the rays; infinite if there is none. warning:
    empty if the bed is flat.
    """

    scenario: str
    source_m: Point
    receiver_m: Point
    range_m: float
    frequency_hz: float
    bottom: str
    bottom_depth_m: float
    profile: Floats
    bed_m: Floats
    arrivals: Arrivals
    warning: str

    def as_dict(self) -> dict[str, Any]:
        """Return plain values, for JSON."""
        return {
            "scenario": self.scenario,
            "from_m": self.source_m,
            "to_m": self.receiver_m,
            "range_m": self.range_m,
            "frequency_hz": self.frequency_hz,
            "bottom": self.bottom,
            "bottom_depth_m": self.bottom_depth_m if math.isfinite(self.bottom_depth_m) else None,
            "warning": self.warning or None,
            "arrivals": [
                dict(zip(vars(self.arrivals), row, strict=True))
                for row in zip(*(values.tolist() for values in vars(self.arrivals).values()), strict=True)
            ],
        }


def rays_between(
    scenario: Scenario, source_m: Point, receiver_m: Point, *, frequency_hz: float = 25_000.0, within_db: float = 20.0
) -> RaysBetween:
    """Return the arrivals between two points of a scenario's water, without waves. Raises ValueError."""
    world = build_world(scenario)
    ends = np.array([source_m, receiver_m])
    range_m = float(np.hypot(*(ends[1] - ends[0])[:2]))
    shares = np.linspace(0.0, 1.0, BED_POINTS)
    heights_m = np.asarray(world.height_at(ends[0, :2] + shares[:, None] * (ends[1] - ends[0])[:2]))
    bed_m = np.column_stack([range_m * shares, -heights_m])
    bottom_m = float(bed_m[BED_POINTS // 2, 1])
    for name, point, bed in (("--from", source_m, bed_m[0, 1]), ("--to", receiver_m, bed_m[-1, 1])):
        if point[2] > 0 or -point[2] > bed:  # false for NaN, where the bed is unknown
            raise ValueError(f"{name} {point[0]:g},{point[1]:g},{point[2]:g}: must be in the water")
    deeper_m = -float(ends[:, 2].min())
    if not bottom_m > deeper_m:  # also where the bed is unknown
        bottom_m = math.inf
    profile = _profile(world, bottom_m if math.isfinite(bottom_m) else deeper_m + range_m)
    bottom = scenario.link.bottom if scenario.link else "silt"
    found = arrivals(
        profile,
        -source_m[2],
        -receiver_m[2],
        range_m,
        None if math.isinf(bottom_m) else bottom,
        bottom_depth_m=bottom_m,
        frequency_hz=frequency_hz,
        within_db=within_db,
    )
    return RaysBetween(
        scenario.name, source_m, receiver_m, range_m, frequency_hz, bottom, bottom_m, profile, bed_m, found,
        _warning(bed_m, bottom_m, deeper_m),
    )  # fmt: skip


def _profile(world: _core.World, deepest_m: float) -> Floats:
    """Return the speed of sound at the levels where its slope changes."""
    speed = _core.sound_speed_profile(world.water)
    depths_m = np.linspace(0.0, min(deepest_m, 12_000.0), LEVELS)
    speeds_m_s = np.array([speed.at(depth) for depth in depths_m])
    bends = np.abs(np.diff(speeds_m_s, 2)) > 1e-9
    kept = np.concatenate([[True], bends, [True]])
    profile: Floats = np.column_stack([depths_m, speeds_m_s])[kept]
    return profile


def _warning(bed_m: Floats, bottom_m: float, deeper_m: float) -> str:
    """Return a warning about how the bed differs from a flat bottom; empty if it is flat enough."""
    if math.isinf(bottom_m):
        known = np.isfinite(bed_m[:, 1])
        return "the bed half-way is above one of the points: no reflections from the bed" if known.any() else ""
    least, most = np.nanmin(bed_m[:, 1]), np.nanmax(bed_m[:, 1])
    if max(most - bottom_m, bottom_m - least) <= FLAT * bottom_m:
        return ""
    blocks = ", and rises into the way of the rays" if least < deeper_m else ""
    return (
        f"the bed between the points is {least:.1f} to {most:.1f} m deep{blocks}: rays are those over a flat bottom at "
        f"{bottom_m:.1f} m, which holds to {100 * FLAT:g} % of the depth"
    )


def text_table(found: RaysBetween) -> str:
    """Return the arrivals as a table, with a line about the water."""
    below = f"{found.bottom} at {found.bottom_depth_m:.1f} m" if math.isfinite(found.bottom_depth_m) else "no bottom"
    lines = [
        f"{found.scenario}: {len(found.arrivals)} arrivals over {found.range_m:.1f} m at {found.frequency_hz:g} Hz, "
        f"{below}",
        "    time [s]  level [dB]  phase [deg]  launch [deg]  arrival [deg]  surface  bottom  turns",
    ]
    one = found.arrivals
    lines += [
        f"{time:12.6f}{level:12.2f}{phase:13.1f}{launch:14.3f}{arrival:15.3f}{surface:9d}{bottom:8d}{turns:7d}"
        for time, level, phase, launch, arrival, surface, bottom, turns in zip(
            one.time_s, one.level_db, np.degrees(one.phase_rad), np.degrees(one.launch_rad),
            np.degrees(one.arrival_rad), one.surface_bounces, one.bottom_bounces, one.turns, strict=True,
        )
    ]  # fmt: skip
    return "\n".join(lines)
