"""`uwsim survey` and `uwsim run` share one engine: the same flight gives the same results with either command."""

import inspect
import json
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import uwsim
from uwsim.cli.autopilots import Autopilots
from uwsim.cli.flags import expanded
from uwsim.cli.run import run
from uwsim.cli.survey import survey
from uwsim.flight.attachment import Elsewhere
from uwsim.flight.coverage import scored_area_m
from uwsim.flight.fly import fly
from uwsim.flight.flyable_lanes import survey_plan
from uwsim.flight.pinging import ping_steps
from uwsim.flight.record import BATTERY_EMPTY, DONE
from uwsim.flight.survey import fly_survey
from uwsim.missions import AdaptiveLawnMower, mow, wait
from uwsim.missions.lawn_mower import COVERED
from uwsim.scenario import load


def mowing(vehicle: Any, scenario: str | Path = "pool") -> Any:
    yield from mow(vehicle, survey_plan(load(scenario).survey))


def idle(vehicle: Any) -> Any:
    yield wait(100.0)


def test_the_lawn_mower_as_a_mission_is_the_survey(surveyed, small_pool: Path, tmp_path: Path) -> None:
    """The map, outcome, score and summary are the same."""
    record, folder = surveyed
    mission = partial(mowing, scenario=small_pool)
    flown = fly(mission, small_pool, tmp_path, map=True, report="json", sample_sensors=False)
    assert flown.occupancy.to_bytes("ot") == record.occupancy.to_bytes("ot")
    values, expected = (json.loads((out / "summary.json").read_text()) for out in (tmp_path, folder))
    assert values.keys() == expected.keys()
    assert values["map"] == expected["map"] and values["map"]["coverage"] > 0.95
    assert values["ended_because"] == expected["ended_because"] == DONE
    parts = ("pings", "echoes", "vehicles", "simulated_s", "pings_with_warning", "ping_interval_s", "path_length_m")
    assert {name: values[name] for name in parts} == {name: expected[name] for name in parts}
    assert (tmp_path / "track-rov.csv").read_bytes() == (folder / "track-rov.csv").read_bytes()


def test_run_and_mow_end_in_the_same_state_to_the_bit(small_pool: Path) -> None:
    with uwsim.Simulator(small_pool) as ran, uwsim.Simulator(small_pool) as mown:
        assert AdaptiveLawnMower(ran.rov, ran, survey_plan(ran.scenario.survey)).run() == COVERED
        fly(partial(mowing, scenario=small_pool), mown, sample_sensors=False)
        assert mown.save_state() == ran.save_state()


def test_an_empty_battery_ends_every_flight_in_the_same_words() -> None:
    sim = uwsim.Simulator("pool", mission_time_s=4.0)
    assert fly_survey(sim)[1].ended_because == fly(mowing, "pool", mission_time_s=4.0).ended_because == BATTERY_EMPTY
    with uwsim.Simulator("pool", mission_time_s=4.0) as flown:
        flown.rov.release()
        flown.advance(4.0)
        assert AdaptiveLawnMower(flown.rov, flown, survey_plan(flown.scenario.survey)).run() == BATTERY_EMPTY


@pytest.mark.parametrize(
    ("step_s", "rate_hz", "expected"), [(0.01, 20.0, 125), (0.005, 50.0, None), (0.005, 10.0, 100)]
)
def test_no_flight_pings_more_often_than_sound_returns(step_s: float, rate_hz: float, expected: int | None) -> None:
    pool = load("pool")
    survey = pool.survey.model_copy(update={"ping_rate_hz": rate_hz})
    scenario = pool.model_copy(update={"step_s": step_s, "survey": survey})
    sim = uwsim.Simulator(scenario, mission_time_s=10.0)
    limit, steps = 10.0 * min(sim.rov.sonar.ping_rate_max_hz, rate_hz), ping_steps(sim, "rov")
    assert steps - 1 < 10.0 / (limit * step_s) <= steps + 1e-9, "a step more apart would be too far, one less too near"
    pings = fly_survey(sim)[1].ping_count
    assert pings == fly(idle, scenario, map=True, mission_time_s=10.0).ping_count == int(10.0 / step_s) // steps
    assert pings <= limit and expected in (None, pings)


def test_a_map_is_scored_over_the_survey_s_area_or_else_where_the_sonar_was() -> None:
    area_m = np.array([[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]])
    over, beside = np.array([[5.0, 5.0, -1.0]]), np.array([[50.0, 5.0, -1.0]])
    assert scored_area_m(area_m, over) is area_m and scored_area_m(area_m, np.empty((0, 3))) is area_m
    for survey_area_m, path_m in ((area_m, beside), (None, beside)):
        found = scored_area_m(survey_area_m, path_m)
        assert np.linalg.norm(found - (50.0, 5.0), axis=1) == pytest.approx(5.0)
    assert scored_area_m(None, np.empty((0, 3))) is None


def test_both_commands_have_the_same_options() -> None:
    """Except for the options that select the mission, the vehicle, and who flies it in place of a survey's mission."""
    of_run, of_survey = (set(inspect.signature(expanded(command)).parameters) for command in (run, survey))
    lanes = {
        "area",
        "altitude_m",
        "spacing_m",
        "speed",
        "heading_deg",
        "entry",
        "overlap",
        "cross_lines",
    }  # of a survey's own mission
    assert of_survey - of_run == lanes
    selects = {"make_map", "vehicle", "argument", "function", *Elsewhere.flags(), *Autopilots.flags()}
    assert of_run - of_survey == selects
