"""An instructor and a trainee, each at a page of their own, in a real browser."""

import json

import numpy as np
import pytest

from browser import exercise_desk, judge, shows, until, when
from uwsim import _core
from uwsim.exercises import load_exercise
from uwsim.scenario.spec.fault import FAULTS
from uwsim.scenario.spec.turbidity import visibility_m

TOKEN = "a-secret-of-18-byte"


@pytest.fixture(scope="module")
def here(browser, tmp_path_factory):
    folder = tmp_path_factory.mktemp("instructor")
    with exercise_desk(browser, folder, load_exercise("hover"), instructor_token=TOKEN) as found:
        yield found


@pytest.fixture(scope="module")
def trainee(here):
    return here.fly(viewport={"width": 1280, "height": 800})


@pytest.fixture(scope="module")
def instructor(here):
    page = here.open(f"/instructor.html#{TOKEN}", viewport={"width": 1280, "height": 900})
    page.wait_for_selector("text=m above the bed")
    return page


@pytest.fixture(autouse=True)
def nothing_complains(here):
    yield
    assert not here.complaints


def call(page, service, **args):
    return page.evaluate(
        """([service, args]) => (globalThis.instructor ?? globalThis.station).station.bridge.call(service, args)
             .catch((error) => ({success: false, message: error.message}))""",
        [f"/{service}", args],
    )


def test_faults_and_water_change_for_the_instructor_alone(here, trainee, instructor):
    sim = here.station.present().live.simulator
    instructor.select_option("[aria-label=Fault]", "sensor")
    instructor.select_option("[aria-label=sensor]", "depth")
    instructor.select_option("[aria-label=mode]", "stuck")
    instructor.click("text=Let it fail")
    until(lambda: sim.faults.active, "a fault")
    instructor.wait_for_selector("text=End sensor")
    instructor.fill("[aria-label='Current sets towards [°]']", "90")
    instructor.fill("[aria-label='Current [m/s]']", "0.2")
    instructor.get_by_role("button", name="Set", exact=True).click()
    until(lambda: sim.parameters["water.current_world_m_s.x"] == 0.2, "a current to the east")
    assert sim.parameters["water.current_world_m_s.y"] == 0.0
    instructor.select_option("[aria-label='Type of water']", "9C")
    until(lambda: sim.parameters["optics.jerlov"] == "9C", "turbid water")
    clear_m = sim.parameters.describe("optics.visibility_m").default
    instructor.focus("[aria-label=Visibility]")
    instructor.keyboard.press("Home")
    until(lambda: sim.parameters["optics.visibility_m"] == pytest.approx(0.1 * clear_m, rel=0.01), "a tenth of it")
    shows(instructor, "label:has([aria-label=Visibility]) output", " m")
    instructor.select_option("[aria-label='Type of water']", "3C")
    of_3c_m = pytest.approx(visibility_m(_core.WaterOptics.jerlov("3C")), rel=1e-6)
    until(lambda: sim.parameters["optics.visibility_m"] == of_3c_m, "that of the type of water")
    instructor.click("#inspect")
    instructor.fill("[aria-label='Search parameters']", "sun_elevation")
    until(lambda: instructor.locator("#inspector input[type=range]:visible").count() == 1, "the sun's slider")
    judge(instructor, "instructor")
    instructor.click("#inspector [aria-label=Close]")
    instructor.click("text=End sensor")
    until(lambda: not sim.faults.active, "no fault")

    judge(trainee, "trainee")
    assert all(trainee.is_hidden(f"#{each}") for each in ("inspect", "pause", "speed", "step"))
    for service, args in (
        ("station/instruct", {"action": "pause"}),
        ("station/overview", {}),
        ("station/parameters", {}),
        ("station/fault_kinds", {}),
        ("station/supervise", {"token": "a-secret-of-18-bytes"}),
        ("station/command", {"name": "inject_fault", "args": {"kind": "sonar"}}),
        ("station/command", {"name": "set_parameter", "args": {"name": "mission_time_s", "value": 9999}}),
        ("station/control", {"action": "restart"}),
        ("simulation/get_parameters", {"names": ["water.current_world_m_s"]}),
        ("simulation/list_parameters", {}),
        ("simulation/reset", {}),
    ):
        assert call(trainee, service, **args)["success"] is False, service
    said = json.dumps(call(trainee, "station/describe")) + json.dumps(trainee.evaluate("station.station.state"))
    assert TOKEN not in said


def test_each_registered_kind_of_fault_can_be_planned(here, trainee, instructor):
    sim = here.station.present().live.simulator
    offered = instructor.locator("[aria-label=Fault] option").evaluate_all("all => all.map(({ value }) => value)")
    assert offered == list(FAULTS.models()) and len(offered) >= 8
    for kind in offered:
        instructor.select_option("[aria-label=Fault]", kind)
        instructor.fill("[aria-label=in_s]", "400")
        instructor.fill("[aria-label=for_s]", "7")
        if kind == "thruster":  # this vehicle has none, but axes
            instructor.select_option("[aria-label=axis]", "surge")
        instructor.click("text=Let it fail")
        if kind == "tether":
            shows(instructor, "#toast", "tether")  # this vehicle has none
        else:
            until(lambda kind=kind: kind in sim.faults.save()["faults"], kind)
    found = call(instructor, "station/overview")["fault_times"]
    planned = [each for each in found if each["end_s"] is None and each["begin_s"] > 300.0]
    assert {each["kind"] for each in planned} == set(offered) - {"tether"}
    assert all(each["planned_end_s"] - each["begin_s"] == pytest.approx(7.0) for each in planned)
    for each in planned:
        ended = call(
            instructor, "station/instruct", action="command", args={"name": "end_fault", "args": {"name": each["name"]}}
        )
        assert ended["success"], ended


def test_a_saved_moment_brings_back_vehicle_and_score(here, trainee, instructor):
    running = here.station.present()
    live, course = running.live, running.judged.course
    trainee.click(".exercise-begin")
    until(lambda: live.tick > 0, "the beginning")
    instructor.click("text=Save this moment")
    instructor.wait_for_selector("text=Return to moment 1")
    saved_s = here.station.present().moments[0].time_s
    with live.privileged():
        live.command("place", vehicle="rov", position_world_m=[0.0, 0.0, -2.5]).result()
    until(lambda: course.state()["goals"][0]["share"] == 1.0, "a goal")
    instructor.click("text=Pause >> nth=0")
    when(trainee, "station.station.state.paused")
    instructor.click("text=Return to moment 1")
    until(lambda: course.state()["goals"][0]["share"] == 0.0, "the score of that moment")
    position = live.read(lambda sim: np.array(sim.rov.pose.position_world_m)).result()
    assert np.linalg.norm(position - [0.0, 0.0, -2.5]) > 1.0
    assert abs(1e-9 * live.time_ns - saved_s) < 0.1 and course.time_s == pytest.approx(saved_s, abs=0.1)
    instructor.click("text=Resume >> nth=0")
    when(trainee, "!station.station.state.paused")
    log = [
        json.loads(line) for line in (here.station.sessions.folder / "instructor-log.jsonl").read_text().splitlines()
    ]
    actions = [entry["action"] for entry in log]
    assert actions[-4:] == ["save_moment", "pause", "return_to", "resume"]
    assert not course.state()["is_valid"], "the instructor returned to a moment"
    assert log[0]["args"]["args"] == {"kind": "sensor", "vehicle": "rov", "sensor": "depth", "mode": "stuck"}
    assert "inject_fault" in [entry.name for entry in live.log]


def test_the_instructor_plans_a_fault_speaks_and_takes_the_controls(here, trainee, instructor):
    running = here.station.present()
    when(instructor, "document.querySelector('.instructor-views canvas').width > 16")  # the trainee's picture
    instructor.select_option("[aria-label=Fault]", "sonar")
    instructor.fill("[aria-label=in_s]", "500")
    instructor.fill("[aria-label=for_s]", "15")
    instructor.click("text=Let it fail")
    instructor.wait_for_selector(".fault-times .is-planned")
    planned = call(instructor, "station/overview")["fault_times"][-1]
    assert planned["planned_end_s"] - planned["begin_s"] == pytest.approx(15.0)
    assert not running.live.simulator.faults.active
    instructor.fill("[aria-label='Message to the trainee']", "Mind the box")
    instructor.click("text=Send")
    shows(trainee, "#instruction", "Instructor: Mind the box")
    pilot = here.station.lease.pilot
    instructor.click("text=Take the controls")
    when(trainee, "!station.station.isPilot")
    assert not call(trainee, "station/drive", vehicle="rov", surge=1.0)["success"]
    instructor.click("text=Give the controls to")
    until(lambda: here.station.lease.pilot == pilot, "the trainee's controls")
    call(trainee, "station/all_stop", vehicle="rov", on=True)
    shows(instructor, ".instructor-log", "all stop")
    entry = call(instructor, "station/overview")["log"][0]
    assert entry["by"].startswith("Pilot") and entry["clock"][:2] == "20"
    course = running.judged.course
    if not course.has_begun:  # by the test before
        trainee.click(".exercise-begin")
        until(lambda: course.has_begun, "the beginning")
    instructor.click("text=End the attempt")
    until(lambda: not course.has_begun, "the end of the attempt")


def test_without_the_token_the_page_shows_nothing(here):
    page = here.open("/instructor.html#a-guess-that-is-wrong")
    page.wait_for_selector("text=token is wrong")
    assert not page.inner_text("#clock")[0].isdigit()
