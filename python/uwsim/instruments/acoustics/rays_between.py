"""The arrivals of sound between two points of a scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.instruments.acoustics.layered_water import Arrivals, arrivals
from uwsim.scenario import Scenario
from uwsim.scenario.build.world import build_world

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
