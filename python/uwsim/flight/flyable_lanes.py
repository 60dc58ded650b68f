"""The survey plan of a scenario, restricted to the parts that can be flown in the true world; its verdict, `checked`.

The mission itself does not see the world; it only receives the remaining lanes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats
from uwsim.base.caught_warnings import caught_warnings
from uwsim.missions.lanes import Lane
from uwsim.missions.lawn_mower import PASSABLE_Z_M
from uwsim.missions.lawn_mower_plan import LawnMowerPlan, missing_for_lanes
from uwsim.scenario import Scenario, ScenarioError, Survey, start_pose
from uwsim.scenario.read.errors import Collected
from uwsim.simulator.simulator import Simulator

STEP_M = 1.0
MARGIN_M = 2.0
"""Width of free water required on all sides of a lane."""
SHORTEST_M = 10.0
"""Length below which a part of a lane is left out."""
TALLEST_M = 1000.0
"""Height of the tallest obstacle that stands out of the water."""
LEAST_SHARE = 0.5
"""The smallest flyable share of lanes with which a survey is accepted; with less, its area must be a mistake."""


class SurveyAreaWarning(UserWarning):
    """Issued when parts of the survey's lanes cannot be flown and are left out."""


@dataclass(frozen=True, eq=False)
class FlyableLanes:
    """The flyable part of a survey's lanes.

    lanes: the lanes that can be flown, in order. left_out: a sentence about the others; None if all can be flown.
    """

    lanes: list[Lane]
    left_out: str | None


def required_survey(scenario: Scenario) -> Survey:
    """Return the scenario's survey. Raises ScenarioError if it has none."""
    if scenario.survey is None:
        raise ScenarioError(
            f"scenario '{scenario.name}': has no survey: specify area_m, altitude_m, line_spacing_m, speed_m_s"
        )
    return scenario.survey


def require_lanes_flown_by(sim: Simulator) -> None:
    """Raise ScenarioError, with all that is missing, if the first vehicle cannot fly a survey's lanes."""
    if missing := missing_for_lanes(sim.rov, required_survey(sim.scenario).altitude_m):
        with sim.scenario.source_file.errors_at("vehicles", 0, "model"):
            lacks = "; ".join(missing.values())
            raise ScenarioError(f"vehicle '{sim.rov.name}' cannot fly the survey's lanes: {lacks}")


def survey_plan(survey: Survey) -> LawnMowerPlan:
    """Return the plan of the scenario's survey."""
    return LawnMowerPlan(
        area_m=survey.area_m,
        altitude_m=survey.altitude_m,
        line_spacing_m=survey.line_spacing_m,
        speed_m_s=survey.speed_m_s,
        tilt_deg=survey.tilt_deg,
        heading_deg=survey.heading_deg,
        cross_lines=survey.cross_lines,
        entry=survey.entry,
    )


def required_plan(sim: Simulator, least_share: float = LEAST_SHARE) -> tuple[LawnMowerPlan, str | None]:
    """Return the plan of the scenario's survey; see flyable_plan. Raises ScenarioError with all that prevents it."""
    plan, found = survey_plan(required_survey(sim.scenario)), Collected()
    left_out = None
    with found.noted():
        require_lanes_flown_by(sim)
    with found.noted():
        plan, left_out = flyable_plan(sim, plan, least_share)
    found.raise_any()
    return plan, left_out


def flyable_plan(
    sim: Simulator, plan: LawnMowerPlan, least_share: float = LEAST_SHARE
) -> tuple[LawnMowerPlan, str | None]:
    """Return the plan, restricted to flyable lanes, and a sentence about those left out, if any.

    Raises ScenarioError if less than least_share of the total lane length can be flown.
    """
    start_m, _ = start_pose(sim.scenario, sim.scenario.vehicles[0])
    lanes = plan.lanes_near(np.array(start_m[:2]))
    found = flyable_lanes(sim, lanes, least_share)
    return (plan, None) if found.left_out is None else (replace(plan, lanes=found.lanes), found.left_out)


def flyable_lanes(sim: Simulator, lanes: list[Lane], least_share: float = LEAST_SHARE) -> FlyableLanes:
    """Return the flyable parts of lanes.

    Raises ScenarioError if they amount to less than least_share of the total length.
    """
    flyable, left_m, reasons_m = [], 0.0, dict.fromkeys((*REASONS, TOO_SHORT), 0.0)
    for lane in lanes:
        along = np.linspace(0.0, lane.length_m, max(2, int(np.ceil(lane.length_m / STEP_M)) + 1))
        why = _obstructions(sim, lane.start_m + along[:, None] * lane.direction)
        free = _stretches(along, why == 0)
        parts = [(low, high) for low, high in free if high - low >= min(SHORTEST_M, lane.length_m)]
        flyable += [
            Lane(lane.start_m + low * lane.direction, lane.start_m + high * lane.direction) for low, high in parts
        ]
        free_m = sum(high - low for low, high in free)
        short_m = free_m - sum(high - low for low, high in parts)
        left_m += lane.length_m - free_m + short_m
        reasons_m[TOO_SHORT] += short_m
        for number, reason in enumerate(REASONS, 1):  # of the rest, by their samples
            reasons_m[reason] += (lane.length_m - free_m) * float((why == number).sum()) / max(1, (why > 0).sum())
    total_m = sum(lane.length_m for lane in lanes)
    if left_m < 1e-6 * total_m:
        return FlyableLanes(lanes, None)
    share = left_m / total_m
    reasons = ", ".join(f"{_percent(m / total_m)} {reason}" for reason, m in reasons_m.items() if m > 0.0)
    sentence = f"{_percent(share)} of the survey's lanes cannot be flown ({reasons})"
    if share > 1.0 - least_share:
        with sim.scenario.source_file.errors_at("survey", "area_m"):
            raise ScenarioError(f"survey.area_m: {sentence}: must be at most {_percent(1.0 - least_share)}")
    return FlyableLanes(flyable, f"{sentence} and are left out.")


REASONS = (
    "outside the terrain",
    f"in water less than {-PASSABLE_Z_M:g} m deep",
    f"at obstacles that reach higher than {-PASSABLE_Z_M:g} m deep",
)
TOO_SHORT = f"in stretches between them that are shorter than {SHORTEST_M:g} m"


def _obstructions(sim: Simulator, points_m: Floats) -> NDArray[np.int64]:
    """Return, for each point (n, 2), 0 if it can be flown over, else a 1-based index into REASONS."""
    ring = np.radians(np.arange(0.0, 360.0, 45.0))
    around = MARGIN_M * np.stack([np.cos(ring), np.sin(ring)], axis=1)
    places = np.concatenate([points_m[:, None], points_m[:, None] + around], axis=1).reshape(-1, 2)
    bed_m = sim.world.height_at(places)
    tops_m = _tops_m(sim, places)
    why = np.select([np.isnan(bed_m), bed_m > PASSABLE_Z_M, tops_m > PASSABLE_Z_M], [1, 2, 3], 0)
    why = np.where(why == 0, len(REASONS) + 1, why).reshape(len(points_m), -1).min(axis=1)
    return np.asarray(np.where(why > len(REASONS), 0, why), np.int64)


def _tops_m(sim: Simulator, places_m: Floats) -> Floats:
    """Return z of the first surface at each point (n, 2), 0 in what stands out of the water; -inf if there is none.

    What lies deeper than twice PASSABLE_Z_M is no obstacle, and over a bed with cover a ray that goes so far takes ten
    times as long.
    """
    up = np.tile([0.0, 0.0, 1.0], (len(places_m), 1))
    from_m = np.column_stack([places_m, np.zeros(len(places_m))])
    ranges_m = sim.scene.cast(from_m, -up, -2.0 * PASSABLE_Z_M).ranges_m
    from_m[:, 2] = PASSABLE_Z_M
    is_inside = sim.scene.cast(from_m, up, TALLEST_M).normals_world[:, 2] > 0.0  # a ray out of a pile, not onto a deck
    return np.where(is_inside, 0.0, -np.asarray(ranges_m, np.float64))


def _stretches(along: Floats, free: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Return the first and last values of `along` in each run of free samples."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], free, [False]]).astype(int)))
    return [(float(along[a]), float(along[b - 1])) for a, b in edges.reshape(-1, 2)]


def _percent(share: float) -> str:
    """Format a share in per cent; a share above 0 is never rounded to 0 %, nor one below 1 to 100 %."""
    return f"{100.0 * share:.0f} %" if share in (0.0, 1.0) else f"{min(max(100.0 * share, 0.1), 99.9):.2g} %"


class Checked(NamedTuple):
    """A verdict. mistakes, warnings: one line each. simulator: the scenario's, None if it cannot be built."""

    mistakes: tuple[str, ...]
    warnings: tuple[str, ...]
    simulator: Simulator | None


def checked(load: Callable[[], Scenario], threads: int | None = None) -> Checked:
    """Build a scenario's simulator and plan its survey, if it has one, as a flight of it would.

    load: returns the scenario, or raises ValueError. Raises OSError.
    """
    simulator, left_out = None, None
    mistakes: tuple[str, ...] = ()
    with caught_warnings() as issued:
        try:
            simulator = Simulator(load(), threads=threads)
            if simulator.scenario.survey is not None:
                left_out = required_plan(simulator)[1]
        except ValueError as error:
            mistakes = tuple(getattr(error, "mistakes", ())) or (str(error),)
    notes = [str(each.message) for each in issued if issubclass(each.category, UserWarning)]
    if simulator is not None and left_out is not None:
        notes.append(f"{simulator.scenario.source_file.line_prefix('survey', 'area_m')}{left_out}")
    return Checked(mistakes, tuple(dict.fromkeys(notes)), simulator)
