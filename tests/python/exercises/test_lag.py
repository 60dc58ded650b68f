"""A lag is the time that sound takes, both ways."""

import pytest

from command_line import error_line, uwsim
from uwsim.exercises import load_exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.lag import with_lag
from uwsim.scenario import ScenarioError, load
from uwsim.simulator.simulator import Simulator


@pytest.mark.parametrize(("name", "lag_s"), [("hover", 0.5), ("gust", 3.0)])
def test_sound_takes_the_lag_from_the_station_to_the_vehicle(name: str, lag_s: float) -> None:
    sim = Simulator(load_exercise(name).model_copy(update={"lag_s": lag_s}).made_scenario())
    assert sim.link is not None
    vehicle = next(iter(sim.vehicles))
    assert sim.link.reception(vehicle, "station").delay_s == pytest.approx(lag_s, rel=2e-3)
    assert sim.link.reception("station", vehicle).delay_s == pytest.approx(lag_s, rel=2e-3)


def test_the_lag_does_not_depend_on_how_the_station_is_turned() -> None:
    scenario = load("pool")
    turned = scenario.model_copy(update={"station": scenario.station.model_copy(update={"yaw_deg": 70.0})})
    sim = Simulator(with_lag(turned, 1.0))
    assert sim.link is not None
    assert sim.link.reception("rov", "station").delay_s == pytest.approx(1.0, rel=2e-3)


def test_a_scenario_with_a_link_has_no_second_one() -> None:
    exercise = load_exercise("hover").model_copy(update={"scenario": "lake_boat", "lag_s": 1.0})
    with pytest.raises(ScenarioError, match="lag_s = 1 s: the scenario has a link of its own"):
        exercise.made_scenario()


def test_a_mission_is_aboard_and_has_no_lag() -> None:
    with pytest.raises(ValueError, match="lag_s = 1 s: must be 0 for a mission, which is aboard"):
        fly_exercise(load_exercise("hover").model_copy(update={"lag_s": 1.0}), None)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--pilot", __file__, "--lag", "1"), "--lag"),
        (("--serve", "--lag", "4"), "--lag = 4.0: must be in [0, 3]"),
    ],
)
def test_mistakes_are_one_line(words: tuple[str, ...], message: str) -> None:
    assert message in error_line(uwsim("exercise", "hover", *words))
