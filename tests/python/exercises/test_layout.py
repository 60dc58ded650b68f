"""The seed of an exercise places the props of its scenario, and the goals that are stated in their frames."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from command_line import error_line, uwsim
from uwsim.exercises import Exercise, load_exercise
from uwsim.scenario import ScenarioError


def course(seed: int, **changes: object) -> Exercise:
    return load_exercise("pool-course").model_copy(update={"seed": seed, **changes})


def leg(exercise: Exercise) -> tuple[float, float, float]:
    places = {one.name: one.position_m for one in exercise.made_scenario().obstacles}  # type: ignore[attr-defined]
    return places["gate_leg_left"]


def test_a_seed_draws_each_prop_by_itself_and_within_its_ranges() -> None:
    legs = np.array([leg(course(seed)) for seed in range(8)])
    assert leg(course(3)) == tuple(legs[3]) and len(np.unique(legs[:, 1])) == 8
    # The gate's middle is at (-6, 0), within 0.5 and 1.5 m; the leg is 1.525 m away from it and turns by 20 degrees.
    turned_m = 1.525 * math.sin(math.radians(20))
    assert (abs(legs[:, 0] + 6) <= 0.5 + turned_m).all() and (abs(legs[:, 1] + 1.525) <= 1.5 + 0.1).all()
    alone = [each for each in course(3).layout if each.prop == "gate"]
    assert leg(course(3, layout=alone)) == leg(course(3))
    scenario = course(3).made_scenario()
    assert len(scenario.obstacles) == len(course(3, layout=[]).made_scenario().obstacles)


def test_goals_follow_their_props() -> None:
    exercise = course(5)
    placed = {one.name: one for one in exercise.made_scenario().obstacles}
    gate, *rows = exercise.in_world().goals[:4]
    assert gate.position_m[:2] == pytest.approx(placed["gate_sign_left"].position_m[:2], abs=0.06)  # type: ignore[attr-defined]  # it leans
    for k, row in enumerate(rows, start=1):
        red, white = (np.array(placed[f"slalom_{k}_{one}"].position_m) for one in ("red", "white_right"))  # type: ignore[attr-defined]
        assert np.array(row.position_m) == pytest.approx((red + white) / 2)  # type: ignore[attr-defined]


def test_props_exchange_their_places_by_the_seed_and_their_goals_with_them() -> None:
    is_red_east = set()
    for seed in range(12):
        exercise = load_exercise("sea-course").model_copy(update={"seed": seed})
        places = {one.name: one.position_m for one in exercise.made_scenario().placed_props}
        goals = {goal.name: goal for goal in exercise.in_world().goals}
        red, yellow = places["red_buoy"], places["yellow_buoy"]
        assert goals["red"].position_m[:2] == red[:2] and goals["yellow"].position_m[:2] == yellow[:2]  # type: ignore[attr-defined]
        assert min(red[0], yellow[0]) < 1.5 < max(red[0], yellow[0])
        is_red_east.add(red[0] > 1.5)
    assert is_red_east == {False, True}


def test_a_board_leans_by_the_seed_and_its_goal_with_it() -> None:
    for seed in (5, 6):
        exercise = course(seed)
        (board,) = [one for one in exercise.made_scenario().placed_props if one.name == "board"]
        assert 0 < abs(board.pitch_deg) <= 5 and 0 < abs(board.roll_deg) <= 5
        (torpedo,) = [goal for goal in exercise.in_world().goals if goal.name == "torpedo"]
        normal = np.array(board.in_world((1.0, 0.0, 0.0))) - board.position_m
        yaw, pitch = np.radians([torpedo.heading_deg, torpedo.pitch_deg])  # type: ignore[attr-defined]
        along = np.array([math.cos(pitch) * math.cos(yaw), math.cos(pitch) * math.sin(yaw), -math.sin(pitch)])
        assert along == pytest.approx(-normal)
        assert torpedo.position_m == pytest.approx(board.in_world((0, -0.15, 1.35)))  # type: ignore[attr-defined]


def test_a_goal_and_a_shift_need_a_prop_of_the_scenario() -> None:
    wrong = course(0)
    goals = [wrong.goals[0].model_copy(update={"of": "gat"}), *wrong.goals[1:]]
    with pytest.raises(ScenarioError, match=r"goals\[0\].of = 'gat': must be a prop of 'course'.*did you mean 'gate'"):
        wrong.model_copy(update={"goals": goals}).in_world()
    shifts = [wrong.layout[0].model_copy(update={"prop": "gat"})]
    with pytest.raises(ScenarioError, match=r"layout\[0\].prop = 'gat': must be a prop of 'course'"):
        wrong.model_copy(update={"layout": shifts}).made_scenario()


def test_several_seeds_are_flown_and_joined(tmp_path: Path) -> None:
    pilot = tmp_path / "pilot.py"
    pilot.write_text("from uwsim.missions import wait\n\n\ndef mission(vehicle):\n    yield wait(1.0)\n")
    result = uwsim("exercise", "pool-course", "--pilot", pilot, "--seed", "1,7-8", "--out", tmp_path / "out")
    assert result.returncode == 0 and "3 seeds: 0.0 of 100 on average" in result.stdout
    rows = json.loads((tmp_path / "out/seeds.json").read_text())
    assert [row["seed"] for row in rows] == [1, 7, 8]


@pytest.mark.parametrize("seeds", ["", "a", "5-2", "1,1", "-3", "1-9999"])
def test_wrong_seeds_are_refused(seeds: str) -> None:
    assert "--seed" in error_line(uwsim("exercise", "pool-course", "--pilot", __file__, f"--seed={seeds}"))


def test_conditions_are_drawn_by_the_seed_each_by_itself_and_within_their_ranges() -> None:
    def drawn(seed: int, **only: object) -> tuple[float, float, float]:
        exercise = load_exercise("sea-course").model_copy(update={"seed": seed})
        if only:
            exercise = Exercise.model_validate({**exercise.given(), "conditions": only})
        scenario = exercise.made_scenario()
        assert scenario.optics.visibility_m is not None
        return (
            math.hypot(*scenario.water.current_world_m_s),
            scenario.optics.visibility_m,
            scenario.optics.sun_elevation_deg,
        )

    all_of = np.array([drawn(seed) for seed in range(6)])
    assert (all_of >= (0.0, 2.5, 15.0)).all() and (all_of <= (0.12, 5.0, 60.0)).all()
    assert [len(np.unique(column)) for column in all_of.T] == [6, 6, 6]
    assert drawn(3, visibility_m=[2.5, 5.0])[1] == all_of[3, 1]
    with pytest.raises(ValueError, match="smaller number first"):
        drawn(0, visibility_m=[5.0, 2.5])
