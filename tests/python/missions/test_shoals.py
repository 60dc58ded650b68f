"""Shoals detected in flight are avoided; shoals known in advance are left out of the plan, or the plan is refused."""

import itertools
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from command_line import error_line, uwsim
from uwsim import Simulator
from uwsim.flight.flyable_lanes import SurveyAreaWarning, flyable_lanes, flyable_plan, survey_plan
from uwsim.flight.record import DONE
from uwsim.flight.survey import fly_survey
from uwsim.missions.lanes import Lane
from uwsim.missions.lawn_mower import PASSABLE_Z_M
from uwsim.missions.shoal_chart import CELL_M, ShoalChart
from uwsim.scenario import load
from uwsim.scenario.read.assets import assets_folder

WALL = [(5, j) for j in range(-4, 5)]
START, GOAL = (2.0, 2.0), (38.0, 2.0)


def chart_of(cells: list[tuple[int, int]]) -> ShoalChart:
    chart = ShoalChart(top_z_m=-3.5)
    for i, j in cells:
        chart.close(((i + 0.5) * CELL_M, (j + 0.5) * CELL_M))
    return chart


def fly(chart: ShoalChart, start: tuple[float, float], goal: tuple[float, float]) -> list[tuple[float, float]] | None:
    """Move towards the next waypoint in 1 m steps until the goal is reached; return the path."""
    path = [start]
    while path[-1] != goal:
        assert len(path) < 500
        aim = chart.next_point(path[-1], goal)
        if aim is None:
            return None
        here, to = np.array(path[-1]), np.array(aim)
        distance = np.linalg.norm(to - here)
        path.append(tuple((to if distance <= 1.0 else here + (to - here) / distance).tolist()))
    return path


def test_the_way_leads_round_a_wall_and_keeps_off_it() -> None:
    for shoals in ([], [(50, 50)]):
        assert chart_of(shoals).next_point(START, GOAL) == GOAL, "straight"
    chart = chart_of(WALL)
    assert chart.next_point(START, GOAL) != GOAL
    path = fly(chart, START, GOAL)
    assert path is not None
    centres_m = (np.array(WALL) + 0.5) * CELL_M
    beside_m = np.abs(np.array(path)[:, None] - centres_m).clip(CELL_M / 2) - CELL_M / 2
    assert np.hypot(*beside_m.T).min() > 0.7 * CELL_M, "it may cut a corner of the cells beside the wall"
    length = sum(np.hypot(*np.subtract(b, a)) for a, b in itertools.pairwise(path))
    assert length < 2 * np.hypot(20.0, 26.0), "no longer than round the wall's end, with its margin"
    for goal in (START, GOAL):
        assert fly(chart_of(WALL), (19.0, 0.0), goal) is not None, "away from beside it"


def test_a_place_in_a_ring_of_shoals_has_no_way_out() -> None:
    ring = [(i, j) for i in range(-6, 7) for j in range(-6, 7) if max(abs(i), abs(j)) == 6]
    assert fly(chart_of(ring), START, (100.0, 0.0)) is None
    assert fly(chart_of(ring), START, (-8.0, 6.0)) is not None


def test_a_shoal_is_charted_from_several_echoes_of_a_ping_that_reach_high_enough() -> None:
    def seen(*heights: float) -> list[tuple[int, int]]:
        chart = ShoalChart(top_z_m=-3.5)
        pose = np.eye(4)
        pose[:3, 3] = (0.0, 0.0, -10.0)
        points = np.array([(21.0 + 0.1 * k, 1.0, z + 10.0) for k, z in enumerate(heights)] + [(np.nan,) * 3] * 5)
        chart.add(SimpleNamespace(points_sonar_m=points, world_from_sonar=pose))
        return chart.cells

    assert seen(-3.0, -3.0, -3.0, -3.0) == [(5, 0)]
    assert seen(-4.0, -4.0, -4.0, -4.0) == []
    assert seen(-3.0) == [], "it may be a false detection"


@pytest.mark.parametrize(
    ("area_m", "reason"),
    [
        ([[-190, -10], [-110, -10], [-110, 10], [-190, 10]], r"in water less than 3\.5 m deep"),
        ([[-130, -125], [-118, -125], [-118, -70], [-130, -70]], r"at obstacles that reach higher than 3\.5 m deep"),
    ],
    ids=["from the shore", "under the station"],
)
def test_a_survey_over_shoals_leaves_them_out_says_why_and_touches_nothing(
    area_m: list[list[float]], reason: str
) -> None:
    lake = load("lake")
    changes = {"area_m": tuple(map(tuple, area_m)), "line_spacing_m": 20.0}
    sim = Simulator(lake.model_copy(update={"survey": lake.survey.model_copy(update=changes)}))
    for lane in flyable_plan(sim, survey_plan(sim.scenario.survey))[0].lanes:
        points = lane.start_m + np.linspace(0.0, 1.0, 500)[:, None] * (lane.end_m - lane.start_m)
        assert sim.world.height_at(points).max() < PASSABLE_Z_M
    with pytest.warns(SurveyAreaWarning, match=rf"^[\d.]+ % of the survey's lanes cannot be flown \(.*{reason}"):
        _, record = fly_survey(sim)
    assert record.ended_because == DONE
    assert record.collisions == 0
    assert record.lanes_left_out is not None and reason.replace("\\", "") in record.lanes_left_out


def test_lanes_do_not_lead_through_a_pile_that_stands_out_of_the_water() -> None:
    sim = Simulator("wind_farm")
    plan = survey_plan(sim.scenario.survey)
    assert flyable_plan(sim, plan) == (plan, None)
    through = Lane(np.array([-30.0, 0.5]), np.array([30.0, 0.5]))  # its monopile has a radius of 3 m
    west, east = flyable_lanes(sim, [through]).lanes
    assert west.end_m[0] == pytest.approx(-5.0, abs=1.0) and east.start_m[0] == pytest.approx(5.0, abs=1.0)


def test_the_reasons_for_lanes_that_are_left_out_are_whole() -> None:
    """About 10 m at a monopile cannot be flown, and the 6 m before them are too short."""
    lane = Lane(np.array([-11.0, 0.5]), np.array([32.0, 0.5]))
    sentence = flyable_lanes(Simulator("wind_farm"), [lane]).left_out
    assert sentence is not None and "shorter than 10 m" in sentence
    whole, *parts = [float(share) for share in re.findall(r"([\d.]+) %", sentence)]
    assert len(parts) == 2 and sum(parts) == pytest.approx(whole, abs=1.0)


def test_an_area_on_the_shore_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    on_shore = "[[-245, -20], [-195, -20], [-195, 20], [-245, 20]]"
    text = (assets_folder() / "scenarios" / "lake.yaml").read_text()
    path = tmp_path / "shore.yaml"
    path.write_text(text.replace("[[-104, -80], [56, -80], [56, 24], [-104, 24]]", on_shore))
    line = error_line(uwsim("survey", str(path), "--out", str(tmp_path / "out")))
    assert f"{path}:" in line
    assert "survey.area_m:" in line and "cannot be flown" in line and "in water less than 3.5 m deep" in line
    assert not (tmp_path / "out").exists()
