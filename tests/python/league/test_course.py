"""A team's folder, its score over seeds in a world that is the referee's, and the table of several teams."""

import os
import re
import runpy
import shutil
import subprocess
import sys
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from mcap.reader import make_reader

from command_line import error_line, uwsim
from uwsim.exercises import load_exercise
from uwsim.league import load_team, score_team
from uwsim.league.bag import record_bag
from uwsim.league.cockpit import Cockpit
from uwsim.league.new import new_team
from uwsim.league.program import Program, ProgramError
from uwsim.league.team import load_course
from uwsim.live import LiveSimulator
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.scenario.load import load
from uwsim.scenario.read.assets import find_yaml
from uwsim.scenario.read.errors import ScenarioError

GATE = """
title: The gate
brief: Pass the gate.
scenario: course
start: {position_m: [-10, 0, -1.1]}
time_s: 60
pass_points: 10
layout: [{prop: gate, x_m: [-0.5, 0.5], y_m: [-1.5, 1.5], yaw_deg: [-20, 20]}]
aids: [{kind: program}]
goals:
  - {kind: pass, name: gate, title: The gate, of: gate, position_m: [0, 0.76, 1.4], heading_deg: 180, within_m: 0.75}
limits: [{kind: collision, cost: 5}]
"""
ANSWERS = """
import json, os, socket
peer = socket.socket(fileno=int(os.environ["UWSIM_COURSE_FD"])).makefile("rw")
def answer(values):
    print(json.dumps(values), file=peer, flush=True)
answer({"reads": READS})
for line in peer:
    if "ended_because" in line:
        break
    answer({"commands": COMMANDS})
"""
SLOW = """
import sys, time
sys.path.insert(0, "src/pilot")
from pilot import pilot, simulated
quick = pilot.Pilot.commands
pilot.Pilot.commands = lambda self: time.sleep(0.01) or quick(self)
simulated.main()
"""


@pytest.fixture(scope="module")
def team(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("teams") / "team"
    assert uwsim("course", "new", folder).returncode == 0
    (folder / "gate.yaml").write_text(GATE)
    (folder / "slow.py").write_text(SLOW)
    return folder


def scored(team: Path, out: Path, seeds: list[int], program: str = "", time_s: float = 60.0, **changes: Any) -> Any:
    """Score a copy of a team, with a program in place of its own."""
    folder = out / "team"
    shutil.copytree(team, folder)
    (folder / "gate.yaml").write_text(GATE.replace("time_s: 60", f"time_s: {time_s:g}"))
    text = (folder / "team.yaml").read_text().replace("pool-course", "gate.yaml")
    if program:
        (folder / "own.py").write_text(program)
        text = text.replace("src/pilot/pilot/simulated.py", "own.py")
    (folder / "team.yaml").write_text(text)
    return score_team(folder, seeds, out / "results", workers=0, **changes).result


def answering(reads: list[str], commands: list[Any]) -> str:
    return ANSWERS.replace("READS", repr(reads)).replace("COMMANDS", repr(commands))


@pytest.mark.parametrize("course", ["pool-course", "sea-course", "reef-course"])
def test_the_new_teams_own_tests_pass_and_an_existing_folder_is_refused(tmp_path: Path, course: str) -> None:
    team = tmp_path / "team"
    new_team(team, course)
    tests = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "src/pilot/test"]
    done = subprocess.run(tests, cwd=team, env={"PYTHONPATH": "src/pilot"}, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout
    assert load_team(team).course == course and load_course(course, team).points == 100.0
    assert "must be a new folder, or an empty one" in error_line(uwsim("course", "new", team))
    lines = sum(len(path.read_text().splitlines()) for path in (team / "src/pilot/pilot").glob("[nps]*.py"))
    assert lines <= 350 and len((team / "src/pilot/pilot/pilot.py").read_text().splitlines()) <= 200


def test_a_course_without_a_pilot_is_refused(tmp_path: Path) -> None:
    refused = error_line(uwsim("course", "new", tmp_path / "team", "--course", "sea-cours"))
    assert "must be one of pool-course, reef-course, sea-course; did you mean 'sea-course'?" in refused
    assert not (tmp_path / "team").exists()


@pytest.mark.parametrize("course", ["sea-course", "reef-course"])
def test_its_pilot_gains_points_from_the_first_lanes_on(tmp_path: Path, course: str) -> None:
    new_team(tmp_path / "team", course)
    whole = find_yaml(course, "exercises").read_text()
    short = tmp_path / "short.yaml"
    short.write_text(re.sub("^time_s: .*", "time_s: 70", whole, flags=re.MULTILINE))
    (run,) = score_team(tmp_path / "team", [5], tmp_path / "results", course=str(short), workers=0).result["runs"]
    assert run["score"] >= 5.0 and run["why"][-1] == "it ended since the time is over", run["why"]
    assert all(reason.startswith("not met: ") for reason in run["why"][:-1]), run["why"]


def test_its_pilot_passes_the_gate_and_the_recording_stays(team: Path, tmp_path: Path) -> None:
    result = scored(team, tmp_path, [5])
    assert result["mean"] == 10.0 and result["passed"] == 1 and result["runs"][0]["why"] == []
    assert (tmp_path / "results/seed-5.mcap").exists() and not (tmp_path / "results").stat().st_mode & 0o077


@pytest.mark.parametrize("name", ["seed-3.log", "seed-3.mcap", "seed-3.json"])
def test_files_of_others_among_the_results_are_kept(team: Path, tmp_path: Path, name: str) -> None:
    (tmp_path / "mine").write_text("mine")
    (tmp_path / name).symlink_to(tmp_path / "mine")
    refused = uwsim("course", "score", team, "--seeds", team / "seeds.txt", "--course", "gate.yaml", "--out", tmp_path)
    assert "uwsim did not write it" in error_line(refused)
    assert (tmp_path / name).is_symlink() and (tmp_path / "mine").read_text() == "mine"


@pytest.mark.skipif(os.geteuid() != 0, reason="only root may run programs as other users")
def test_the_program_of_another_user_has_no_right_and_no_file_of_the_referees(tmp_path: Path) -> None:
    """Not even the name of its log, which states the seed."""
    look = f"id -u daemon; id -u; id -g daemon; id -G; readlink /proc/$$/fd/1; ls {tmp_path}"
    program = Program(["/bin/sh", "-c", look], Path("/"), tmp_path / "seed-5.log", "daemon")
    with program, pytest.raises(ProgramError, match="Permission denied"):
        program.receive()
    user, its_user, group, its_groups, output, _ = (tmp_path / "seed-5.log").read_text().splitlines()
    assert (its_user, its_groups) == (user, group) and output.startswith("pipe:")


@pytest.mark.parametrize("course", ["pool-course", "sea-course", "reef-course"])
def test_its_launch_file_serves_the_courses_world(tmp_path: Path, course: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """The words of its process, without ROS: stand-ins for `launch` keep what they are given."""
    given: dict[str, Any] = {}
    values = {"simulator": "true", "seed": "3"}
    parts: dict[str, Any] = {
        "DeclareLaunchArgument": lambda name, default_value: values.setdefault(name, default_value),
        "ExecuteProcess": lambda **keys: given.update(keys),
        "LaunchConfiguration": lambda name: lambda: values[name],
        **dict.fromkeys(("IfCondition", "Node", "LaunchDescription"), lambda *some, **keys: some),
    }
    for name in ("launch", "launch.actions", "launch.conditions", "launch.substitutions", "launch_ros.actions"):
        monkeypatch.setitem(sys.modules, name, SimpleNamespace(**parts))
    new_team(tmp_path / "team", course)
    made = runpy.run_path(str(tmp_path / "team/src/pilot/launch/course.launch.py"))
    made["generate_launch_description"]()
    shell, option, words = given["cmd"]
    write, serve = "".join(each() if callable(each) else each for each in words).split(" && exec ")
    assert (shell, option) == ("sh", "-c") and write.startswith(f"uwsim course world {course} ")
    assert uwsim(*write.split()[1:]).returncode == 0
    world = serve.split()[2]
    seeded = load_exercise(course).model_copy(update={"seed": 3}).made_scenario()
    assert serve == f"uwsim serve {world} --ros2 --tf odom"
    assert scenario_fingerprint(load(world)) == scenario_fingerprint(seeded)


def test_a_bag_has_the_beginning_of_a_run_with_scans_and_pictures(team: Path, tmp_path: Path) -> None:
    bag = tmp_path / "first.mcap"
    missing = record_bag(team, 1, bag, until_s=1.0)
    assert missing.endswith("it ended since the time is over") and bag.stat().st_size < 1e6
    with bag.open("rb") as stream:
        found = make_reader(stream).get_summary()
    assert found is not None and found.statistics is not None
    counts = {found.channels[k].topic: n for k, n in found.statistics.channel_message_counts.items()}
    assert counts["/scan"] >= 5 and counts["/odom"] >= 40 and counts["/tf"] >= 40
    assert [n for topic, n in counts.items() if topic.startswith("/camera/")] == [3, 3]
    assert [topic for topic in counts if topic.startswith("/camera/") and "front" not in topic] == []


def test_a_slow_program_flies_the_same_run(team: Path, tmp_path: Path) -> None:
    for name, program in (("quick", ""), ("slow", SLOW)):
        scored(team, tmp_path / name, [5], program, time_s=6.0)
    recordings = [tmp_path / name / "results/seed-5.mcap" for name in ("quick", "slow")]
    difference = uwsim("recording", "diff", *recordings)
    assert difference.returncode == 0, difference.stdout


@pytest.mark.parametrize(
    ("program", "because"),
    [
        (answering(["odom"], [["cmd_vel", {"linear": {"x": 0.5}}]]), "the program is blind"),
        (answering(["scan"], []), "has not commanded the vehicle once"),
        (answering(["scans"], []), "topic 'scans': is none that is read"),
        (answering(["ground_truth/odom"], []), "topic 'ground_truth/odom': is none that is read"),
        (answering(["scan"], [["cmd_vel", {"linear": {"x": "fast"}}]]), "msg.linear.x = 'fast': must be a number"),
        (answering(["scan"], [["simulation/reset", {}]]), "'simulation/reset': is no topic or service"),
        (answering(["scan"], [["apply_wrench", {"force_n": [9.0, 0.0, 0.0]}]]), "refused: an exercise is flown"),
        (answering(["scan"], ["stop"]), "stop: must be a list of a name and an object"),
        ("raise SystemExit('no camera')", "has ended, with exit code 1: no camera"),
        ("import os, socket\nsocket.socket(fileno=int(os.environ['UWSIM_COURSE_FD'])).sendall(b'x\\n')\n", "answer"),
    ],
)
def test_a_bad_program_gains_nothing_and_is_told_why(team: Path, tmp_path: Path, program: str, because: str) -> None:
    result = scored(team, tmp_path, [1], program, time_s=1.0)
    (run,) = result["runs"]
    assert run["score"] == 0.0 and any(because in reason for reason in run["why"]), run["why"]


def test_the_true_pose_and_the_world_are_closed(team: Path) -> None:
    exercise = load_course("gate.yaml", team)
    with LiveSimulator(exercise.made_scenario(), paused=True) as live, Cockpit(live, exercise) as door:
        names = {*door.outputs, *door.services}
        assert not [name for name in names if "truth" in name or "map" in name or "simulation" in name]
        assert {name.split("/")[1] for name in names if name.startswith("camera/")} == {"front"}
        odom = door.outputs["odom"].read(live.simulator)
        assert odom.pose.pose.orientation.z != live.simulator.rov.pose.orientation_xyzw[2]
        with pytest.raises(ValueError, match="refused: an exercise is flown"):
            live.step(1)


def test_pictures_come_at_the_rate_of_the_camera_or_at_the_teams(tmp_path: Path) -> None:
    camera = "cameras: {front: {position_m: [0.2, 0, 0.06], width: 32, height: 24, rate_hz: 5}}"
    world = (
        find_yaml("course", "scenarios").read_text().replace("sensors: {bearing", f"{camera}\n      sensors: {{bearing")
    )
    (tmp_path / "course.yaml").write_text(world)
    (tmp_path / "gate.yaml").write_text(GATE.replace("scenario: course", f"scenario: {tmp_path / 'course.yaml'}"))
    exercise = load_course("gate.yaml", tmp_path)
    for pictures_hz, apart_ns in ((None, 200_000_000), (2.0, 500_000_000)):
        with LiveSimulator(exercise.made_scenario(), paused=True) as live, Cockpit(live, exercise, pictures_hz) as door:
            door.read_topics(["camera/front/camera_info"])
            with live.privileged():
                live.step(round(1.5 / live.simulator.step_s))
            stamps = [message["header"]["stamp"] for _, message in door.look()["messages"]]
            times_ns = sorted({10**9 * stamp["sec"] + stamp["nanosec"] for stamp in stamps})
            assert len(times_ns) >= 3 and {b - a for a, b in pairwise(times_ns)} == {apart_ns}
    (tmp_path / "team.yaml").write_text("name: a\ncourse: gate.yaml\nprogram: [x]\npictures_hz: 6\n")
    with pytest.raises(ScenarioError, match=r"pictures_hz = 6 Hz: must be at most 5 Hz, the rate of .* camera 'front'"):
        score_team(tmp_path, [1], tmp_path / "results")
    assert not (tmp_path / "results").exists()


def test_a_program_reports_what_it_has_found_and_time_left_counts_once_all_is_met(team: Path, tmp_path: Path) -> None:
    text = (
        GATE[: GATE.index("goals:")].replace("pass_points: 10", "pass_points: 1")
        + """
goals:
  - {kind: report, name: here, title: A note, position_m: [1, 2, -1], within_m: 0.5, category: growth, points: 4}
  - {kind: time_left, name: early, title: Early, after: [here], full_s: 0, none_s: 2, points: 8}
limits: [{kind: reports, category: growth, most: 5, cost: 1}]
"""
    )
    note = ["note", {"text": "coral", "category": "growth", "position_world_m": [1.0, 2.3, -1.0]}]
    bare = ["note", {"category": "growth", "position_world_m": [1.0, 2.3]}]
    for name, command in (("near", note), ("wrong", bare)):
        folder = tmp_path / name
        shutil.copytree(team, folder)
        (folder / "gate.yaml").write_text(text.replace("time_s: 60", "time_s: 1"))
        (folder / "own.py").write_text(answering(["scan"], [command]))
        (folder / "team.yaml").write_text("name: a\ncourse: gate.yaml\nprogram: [python3, own.py]\n")
    (run,) = score_team(tmp_path / "near", [1], tmp_path / "a", workers=0).result["runs"]
    assert run["ended_because"] == "all goals are met" and run["goals"]["here"] == 4.0
    assert run["goals"]["early"] == pytest.approx(8.0 * (1.0 - run["time_s"] / 2.0))  # a straight line from 8 to 0
    (run,) = score_team(tmp_path / "wrong", [1], tmp_path / "b", workers=0).result["runs"]
    assert run["score"] == 0.0 and any("text: must be given" in reason for reason in run["why"]), run["why"]


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("name: a\ncourse: pool-course\nprogram: []\n", "program"),
        ("name: a\ncourse: hover\nprogram: [x]\n", "aids: must have the kind program"),
        ("name: a\ncourse: pool-course\nprogram: [no-such-program]\n", "cannot be started"),
    ],
)
def test_a_wrong_team_is_refused_in_one_line(tmp_path: Path, text: str, rule: str) -> None:
    (tmp_path / "team.yaml").write_text(text)
    (tmp_path / "seeds.txt").write_text("# one\n1\n")
    words = ("course", "score", tmp_path, "--seeds", tmp_path / "seeds.txt", "--out", tmp_path / "o", "--workers", "0")
    assert rule in error_line(uwsim(*words))
