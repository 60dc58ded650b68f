"""Each packaged exercise gives full marks to a pilot who does what it asks, and not to one who does not."""

import contextlib
import itertools
import json
import math
import re
from pathlib import Path

import pytest

from arm_pilots import ARM_PILOTS, pull_the_pin
from dive_pilots import DIVES
from uwsim.exercises import Exercise, exercise_names, load_exercise
from uwsim.exercises.flight import fly_exercise
from uwsim.exercises.goal import GOALS
from uwsim.missions import dive_to, follow, goto, hold, turn_to, wait
from uwsim.scenario import ScenarioError
from uwsim.scenario.read.validated import validated
from uwsim.scenario.schema import schema

pytestmark = pytest.mark.usefixtures("blank_figures")
GUIDE = Path(__file__).parents[3] / "docs/guides/exercises.md"


def hover(vehicle):
    yield from goto(vehicle, (0, 0, -2.5), within_m=0.3)
    yield from hold(vehicle, 33.0, position_world_m=(0, 0, -2.5))
    yield from turn_to(vehicle, math.pi / 2)
    yield from hold(vehicle, 20.0, position_world_m=(0, 0, -2.5), heading_rad=math.pi / 2)


def hover_carelessly(vehicle):
    """Reaches the place, and then lets the vehicle drift off with a little thrust."""
    yield from goto(vehicle, (0, 0, -2.5), within_m=0.3)
    vehicle.set_effort(surge=0.2)
    yield wait(60.0)


def gates():
    return [goal for goal in load_exercise("slalom").goals if goal.kind == "pass"]


def through(vehicle, gates, by_m=1.5, aside_m=(), within_m=0.3):
    """Fly through the middle of gates, or beside those that are given a distance."""
    for gate, aside in itertools.zip_longest(gates, aside_m, fillvalue=0.0):
        (x, y, z), heading = gate.position_m, math.radians(gate.heading_deg)
        for by in (-by_m, by_m):
            place = (x + by * math.cos(heading), y + by * math.sin(heading) + aside, z)
            yield from goto(vehicle, place, within_m=within_m, speed_m_s=0.6, heading_rad=heading)


def slalom(vehicle):
    yield from through(vehicle, gates(), by_m=1.8)


def slalom_past_the_third(vehicle):
    """Flies past the third ring; the later ones do not count then."""
    yield from through(vehicle, gates(), by_m=1.8, aside_m=(0, 0, 3), within_m=0.4)


PIPE = [(-18, -6.5), (-13, -7.75), (-8, -9), (-2, -7.5), (4, -6), (10, -8), (14, -9.3)]


def pipeline(vehicle):
    yield from goto(vehicle, (*PIPE[0], -7.0))
    for place in PIPE[1:]:
        yield from goto(vehicle, (*place, -6.5), within_m=0.3)
        if place in ((-13, -7.75), (-2, -7.5), (10, -8)):
            yield from hold(vehicle, 6.0)
            vehicle.command("note", text="Corrosion", category="defect", position_world_m=(*place, -8.0))


def pipeline_in_a_hurry(vehicle):
    """Follows the pipe without a stop, so high that no defect is within the reach of its camera."""
    yield from follow(vehicle, [(*place, -5.0) for place in PIPE], speed_m_s=1.0)


def released(vehicle, dropper, mount_m, aim_m, ahead, back_m=0.0):
    """Bring a dropper over a place, or a launcher before it, along a heading, and let go of what it holds."""
    (mx, my, mz), (x, y, z) = mount_m, aim_m
    x -= (mx + back_m) * math.cos(ahead) - my * math.sin(ahead)
    y -= (mx + back_m) * math.sin(ahead) + my * math.cos(ahead)
    yield from goto(vehicle, (x, y, z - mz), heading_rad=ahead, within_m=0.2)
    yield from hold(vehicle, 12.0, position_world_m=(x, y, z - mz), heading_rad=ahead)
    vehicle.command("drop", dropper=dropper)
    yield from hold(vehicle, 8.0, position_world_m=(x, y, z - mz), heading_rad=ahead)


def pool_course(vehicle):
    for goal in load_exercise("pool-course").in_world().goals:
        if goal.kind == "bring":
            x, y, z = goal.position_m
            yield from released(vehicle, "marker_dropper", (-0.1, 0.0, -0.2), (x, y, z + 0.5), 0.0)
            continue
        if goal.name == "torpedo":
            ahead = math.radians(goal.heading_deg)
            yield from released(vehicle, "torpedo_tube", (0.1, -0.32, -0.05), goal.position_m, ahead, back_m=0.8)
            continue
        (x, y, z), ahead = goal.position_m, math.radians(getattr(goal, "heading_deg", 0.0))
        for along_m in (-0.6, 0.6) if goal.kind == "pass" else (0.0,):
            at_m = (x + along_m * math.cos(ahead), y + along_m * math.sin(ahead), min(z, -0.1))
            yield from goto(vehicle, at_m, within_m=0.2)


def pool_course_by_dead_reckoning(vehicle):
    """Flies straight to where the octagon is in the scenario."""
    yield from goto(vehicle, (9.5, 0, -1), within_m=0.5)


def seen(vehicle, goal, back_m=1.2, up_m=0.5, ahead=0.0):
    """Look at a goal's place from behind it, along a heading [rad]."""
    x, y, z = goal.position_m
    yield from goto(vehicle, (x - back_m * math.cos(ahead), y - back_m * math.sin(ahead), z + up_m + 1.5), within_m=0.3)
    yield from turn_to(vehicle, ahead)
    yield from hold(
        vehicle, 6.0, position_world_m=(x - back_m * math.cos(ahead), y - back_m * math.sin(ahead), z + up_m)
    )


def sea_course(vehicle):
    yield from tasks(vehicle, load_exercise("sea-course"), up_m=0.4)
    for k, y in enumerate((-5.5, -1.5, 2.5, 6.0)):
        for x in (-8.0, 8.0) if k % 2 else (8.0, -8.0):
            yield from goto(vehicle, (x, y, -1.5), within_m=0.5)


def sea_course_without_a_look(vehicle):
    yield from goto(vehicle, (8, -5.5, -1.5), within_m=0.5)


def tasks(vehicle, course, up_m=0.5):
    """Look, note and stay, as the goals of a course ask, but for those that are not of these kinds."""
    for goal in course.in_world().goals:
        if goal.kind == "look_at":
            yield from seen(vehicle, goal, up_m=up_m)
        elif goal.kind == "report":
            vehicle.command("note", text=goal.title, category=goal.category, position_world_m=goal.position_m)
        elif goal.kind == "hold":
            yield from goto(vehicle, goal.position_m, within_m=0.2)
            yield from hold(vehicle, 13.0, position_world_m=goal.position_m)
        elif goal.kind == "move_joint":
            yield from pull_the_pin_and_return(vehicle, course)


def reef_course(vehicle):
    yield from tasks(vehicle, load_exercise("reef-course"))


def pull_the_pin_and_return(vehicle, course, north_m=-1.2):
    """north_m: where the way back to the plate is; the way out is north of the posts at (0, -2.8) m."""
    (console,) = [one for one in course.made_scenario().placed_props if one.name == "console"]
    yield from goto(vehicle, (2.0, -1.2, -2.5), within_m=0.4)
    yield from pull_the_pin(vehicle, console)
    for x in (3.0, -2.0):
        yield from goto(vehicle, (x, north_m, -3.0), within_m=0.4)


def rov_course(vehicle):
    yield from tasks(vehicle, load_exercise("rov-course"))


def rov_course_the_shortest_way_back(vehicle):
    """Pulls the pin, and flies to the plate south of a post, round which the tether then is."""
    course = load_exercise("rov-course")
    yield from pull_the_pin_and_return(vehicle, course, north_m=-4.2)
    yield from tasks(vehicle, course.model_copy(update={"goals": [one for one in course.goals if one.kind == "hold"]}))


def reef_course_by_the_plate_alone(vehicle):
    yield from goto(vehicle, (-3, -4, -4), within_m=0.2)


def approach(vehicle):
    yield from goto(vehicle, (0, 0, -2.2))
    yield from goto(vehicle, (-4.5, 0, -2), within_m=0.3)
    yield from hold(vehicle, 25.0, position_world_m=(-4.5, 0, -2))


def approach_without_the_current(vehicle):
    """Reaches the place, and then rests on its oars."""
    yield from goto(vehicle, (0, 0, -2.2))
    yield from goto(vehicle, (-4.5, 0, -2), within_m=0.3)
    vehicle.set_effort()
    yield wait(60.0)


def keep_height(vehicle, error_m, duration_s):
    """Steer up and down by a reading alone."""
    kept, end_s = 0.0, vehicle.time_s + duration_s
    while vehicle.time_s < end_s:
        error = error_m()
        kept = min(max(kept + 0.02 * error, -0.5), 0.5)
        speed = vehicle.velocity.linear_body_m_s[2]
        vehicle.set_effort(heave=min(max(1.0 * error + kept - 0.8 * speed, -0.8), 0.8))
        yield wait(0.1)


def depth_gauge(vehicle):
    altitude = vehicle.sensors["altitude"]
    yield from dive_to(vehicle, 2.5)
    yield from keep_height(vehicle, lambda: 2.5 - altitude.read(), 75.0)


def depth_gauge_believed(vehicle):
    """Steers by the gauge, which shows 2.5 m for ever."""
    gauge = vehicle.sensors["depth"]
    yield from keep_height(vehicle, lambda: gauge.read() - 2.5, 120.0)


def gust(vehicle):
    yield from goto(vehicle, (0, 0, -2.5), within_m=0.3, heading_rad=0.0)
    yield from hold(vehicle, 34.0, position_world_m=(0, 0, -2.5), heading_rad=0.0)


def gust_without_holding(vehicle):
    """Reaches the middle, and rests there as if the water stood still."""
    yield from goto(vehicle, (0, 0, -2.5), within_m=0.3, heading_rad=0.0)
    vehicle.set_effort()
    yield wait(20.0)


def docking(vehicle):
    yield from goto(vehicle, (-8, 0, -2), within_m=0.3)
    yield from turn_to(vehicle, 0.0)
    yield from hold(vehicle, 7.0, position_world_m=(-8, 0, -2), heading_rad=0.0)
    yield from goto(vehicle, (-6.5, 0, -2), within_m=0.3, speed_m_s=0.3, heading_rad=0.0)
    vehicle.dock()
    yield wait(0.3)


def docking_sideways(vehicle):
    """Comes as it is, and asks for the dock facing north: it is refused."""
    yield from goto(vehicle, (-8, 0, -2), within_m=0.3, heading_rad=math.pi / 2)
    yield from goto(vehicle, (-6.5, 0, -2), within_m=0.3, heading_rad=math.pi / 2)
    with contextlib.suppress(ValueError):
        vehicle.dock()


def thruster_loss(vehicle):
    yield from goto(vehicle, (5, 0, -2.5), within_m=0.3)
    yield from hold(vehicle, 12.0, position_world_m=(5, 0, -2.5))


def thruster_loss_unnoticed(vehicle):
    """Pushes ahead for the time that the way takes with all thrusters."""
    vehicle.set_effort(surge=0.3)
    yield wait(12.0)


def dvl_loss(vehicle):
    """Flies by the estimate, which has the USBL's fixes left."""
    yield from goto(vehicle, (4, 4, -2.5))
    yield from goto(vehicle, (-3, -3, -2.5), within_m=0.4)
    yield from hold(vehicle, 12.0, position_world_m=(-3, -3, -2.5))


def dvl_loss_by_time(vehicle):
    """Comes back by time and heading, as in still water."""
    yield from goto(vehicle, (4, 4, -2.5))
    yield from turn_to(vehicle, math.radians(-135.0))
    vehicle.set_effort(surge=0.12)
    yield wait(20.0)
    vehicle.set_effort()
    yield wait(10.0)


def night_gates(vehicle):
    vehicle.lamps["front"].on = True
    yield from through(vehicle, load_exercise("night-gates").goals)


def night_gates_past_the_second(vehicle):
    yield from through(vehicle, load_exercise("night-gates").goals[:2], aside_m=(0, 3))


PILOTS = {
    "hover": (hover, hover_carelessly),
    "slalom": (slalom, slalom_past_the_third),
    "pipeline": (pipeline, pipeline_in_a_hurry),
    "pool-course": (pool_course, pool_course_by_dead_reckoning),
    "sea-course": (sea_course, sea_course_without_a_look),
    "reef-course": (reef_course, reef_course_by_the_plate_alone),
    "rov-course": (rov_course, reef_course_by_the_plate_alone),
    "approach": (approach, approach_without_the_current),
    "depth-gauge": (depth_gauge, depth_gauge_believed),
    "gust": (gust, gust_without_holding),
    "docking": (docking, docking_sideways),
    "thruster-loss": (thruster_loss, thruster_loss_unnoticed),
    "dvl-loss": (dvl_loss, dvl_loss_by_time),
    "night-gates": (night_gates, night_gates_past_the_second),
    **DIVES,
    **ARM_PILOTS,
}
OPTIONS = {"dvl-loss": {"estimate": "filter"}}


def test_all_packaged_exercises_are_flown_here_and_described_in_the_guide():
    assert set(exercise_names()) == set(PILOTS)
    table = GUIDE.read_text().partition("| packaged |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `([\w-]+)`", table, re.MULTILINE) == exercise_names(), "in the order of the course"


@pytest.mark.parametrize("name", PILOTS)
def test_full_marks_for_the_good_pilot_and_not_for_the_bad(name):
    good, bad = PILOTS[name]
    options = OPTIONS.get(name, {"sample_sensors": False})
    if good is not None:  # else by keys: operator/test_arm_by_keys.py
        course = fly_exercise(name, good, **options).course
        assert course.score == course.exercise.points, course.sheet()
        assert course.has_passed and course.sheet()["ended_because"] == "all goals are met"
    course = fly_exercise(name, bad, **options).course
    assert course.score < course.exercise.points, course.sheet()
    assert not course.has_passed


@pytest.mark.parametrize("name", ARM_PILOTS)
def test_what_a_gripper_is_to_do_does_not_happen_by_itself(name):
    def stay(vehicle):
        yield from hold(vehicle, 10.0)

    course = fly_exercise(name, stay, sample_sensors=False).course
    assert [goal["share"] for goal in course.state()["goals"]] == [0.0] * len(course.exercise.goals)


def test_the_shortest_way_back_leaves_the_tether_round_a_post():
    sheet = fly_exercise("rov-course", rov_course_the_shortest_way_back, sample_sensors=False).course.sheet()
    shares = {goal["name"]: goal["share"] for goal in sheet["goals"]}
    assert (shares["pin"], shares["plate"], shares["tether"]) == (1.0, 1.0, 0.0)


def test_a_goal_for_an_object_that_is_not_there_is_refused():
    values = {"title": "T", "brief": "B", "scenario": "panel", "pass_points": 5, "time_s": 5}
    joint, to = {"kind": "move_joint", "object": "valve", "joint": "handle"}, {"to_deg": 9}
    for goal, rule in (
        (joint | to | {"object": "sample"}, "must be one of valve, lock"),
        (joint | to | {"joint": "lever"}, "must be one of handle"),
        (joint, "give one of to_deg and to_m"),
        ({"kind": "bring", "object": "valve", "position_m": [0, 0, -3]}, "must be one of sample, plug"),
    ):
        with pytest.raises((ScenarioError, ValueError), match=rule):
            fly_exercise(validated(Exercise, values | {"goals": [goal | {"name": "g", "title": "G"}]}), hover)


def test_the_sheet_and_the_same_flight_twice(tmp_path):
    sheets = []
    for name in "ab":
        fly_exercise("approach", approach, tmp_path / name)
        sheets.append(json.loads((tmp_path / name / "score.json").read_text()))
    sheet, again = sheets
    assert {**again, "date": sheet["date"], "digest": sheet["digest"]} == sheet
    assert [e["text"] for e in sheet["log"] if e["kind"] == "event"][1] == "the current grows to 0.2 m/s"
    assert 0.0 < sheet["goals"][2]["error_mean_m"] <= sheet["goals"][2]["error_max_m"]
    page = (tmp_path / "a/sheet.html").read_text()
    assert "Passed" in page and page.count("data:image/png") == 3


def made(title, goals, **values) -> Exercise:
    """An exercise in the pool, of which 5 points pass."""
    common = {"title": title, "brief": title, "scenario": "pool", "pass_points": 5}
    return Exercise.model_validate({**common, "goals": goals, **values})


def test_a_mapped_area_counts_by_its_cells():
    area = [[-3, -3], [3, -3], [3, 3], [-3, 3]]
    goal = {"kind": "map", "name": "bed", "title": "Map the bed", "area_m": area, "share": 0.5}
    exercise = made("Map", [goal], time_s=60, start={"position_m": [-5, 0, -2.5]})

    def along(vehicle):
        yield from goto(vehicle, (5, 0, -2.5))

    def stay(vehicle):
        yield wait(20.0)

    assert fly_exercise(exercise, along).course.score == 10.0
    assert fly_exercise(exercise, stay).course.score < 5.0


UNKNOWN = "{kind: sensor, sensor: dep}"
GOOD = """\
title: One
brief: Two
scenario: pool
pass_points: 10
goals:
  - {kind: reach, name: there, title: There, position_m: [0, 0, -2]}
"""


def test_mistakes_are_reported_before_the_flight(tmp_path):
    path = tmp_path / "mine.yaml"
    for old, new, expected in (
        ("pass_points: 10", "pass_points: 11", "must be at most 10"),
        ("kind: reach", "kind: rich", "kind"),
        ("position_m: [0, 0, -2]", "position_m: [0, 0, -2], after: nowhere", "must be the name of an earlier goal"),
        ("goals:", "events:\n  - {at_s: 1, after: there, command: end_fault}\ngoals:", "exactly one of at_s"),
        ("goals:", "events:\n  - {at_s: 1, command: place}\ngoals:", "must be one of inject_fault"),
        ("scenario: pool", "scenario: poll", "did you mean 'pool'"),
        ("goals:", f"events:\n  - {{at_s: 1, command: inject_fault, arguments: {UNKNOWN}}}\ngoals:", "events[0]"),
        ("title: One", "titel: One", "did you mean 'title'"),
    ):
        path.write_text(GOOD.replace(old, new))
        with pytest.raises((ScenarioError, ValueError)) as raised:
            fly_exercise(path, hover)
        assert expected in str(raised.value)


def test_a_report_counts_by_its_place_and_its_category_and_many_cost():
    goals = [
        {"kind": "report", "name": name, "title": name, "position_m": [x, 0, -3], "within_m": 1}
        for name, x in (("near", 1), ("far", 4))
    ]
    limits = [{"kind": "reports", "most": 2, "cost": 3}]
    exercise = made("Report", goals, time_s=5, limits=limits, start={"position_m": [0, 0, -2.5]})

    def reporting(*notes):
        def pilot(vehicle):
            for category, place in notes:
                vehicle.command("note", text="", category=category, position_world_m=place)
                yield wait(1.0)

        return fly_exercise(exercise, pilot).course.score

    assert reporting(("defect", (1.2, 0.5, -3.0))) == 10.0
    assert reporting(("debris", (1.0, 0.0, -3.0)), ("defect", None), ("defect", (2.1, 0.0, -3.0))) == 0.0
    assert reporting(*[("defect", (x, 0.0, -3.0)) for x in (-1.0, 0.0, 1.0)]) == 10.0 - 3.0


def test_a_path_counts_in_order_and_a_ring_in_its_direction():
    """A pilot who flies the path, or through the ring, the other way, gets nothing for it."""
    goals = [
        {"kind": "follow", "name": "path", "title": "Path", "points_m": [[-4, 4, -2.5], [4, 4, -2.5]]},
        {"kind": "pass", "name": "ring", "title": "Ring", "position_m": [0, 4, -2.5], "heading_deg": 0},
    ]
    exercise = made("Order", goals, time_s=90, start={"position_m": [4, 4, -2.5], "yaw_deg": 180})

    def backwards(vehicle):
        yield from goto(vehicle, (-4, 4, -2.5))

    shares = [goal["share"] for goal in fly_exercise(exercise, backwards).course.state()["goals"]]
    assert shares[0] < 0.3 and shares[1] == 0.0


def test_the_guide_and_the_schema_list_each_kind_of_goal() -> None:
    table = GUIDE.read_text().partition("| goal |")[2].partition("\n\n")[0]
    assert re.findall(r"^\| `(\w+)`", table, re.MULTILINE) == list(GOALS.models())
    definitions = schema("exercise", {"exercise": Exercise})["definitions"]
    kinds = [definitions[model.__name__]["properties"]["kind"]["const"] for model in GOALS.models().values()]
    assert kinds == list(GOALS.models())
