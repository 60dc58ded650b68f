"""Mission flights: their records, how they end, and that a resumed flight produces the same map."""

import json
import signal
import subprocess
import time
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import UWSIM, error_line, wait_for
from command_line import uwsim as run_uwsim
from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.fly import fly, resume
from uwsim.flight.mission_file import MissionError
from uwsim.flight.record import BATTERY_EMPTY
from uwsim.mapping import OccupancyMap
from uwsim.missions import StoppedError, goto, hold, parallel, turn_to, wait
from uwsim.scenario.read.assets import assets_folder

ROUND = """
from uwsim.missions import goto, turn_to

def mission(vehicle, depth_m=2.5):
    vehicle.undock()
    vehicle.log("out", free=True)
    vehicle.sonar.aim(-0.5)
    for x, y in ((0.0, 3.0), (-3.0, -3.0), (1.0, -3.0)):
        yield from goto(vehicle, (x, y, -depth_m))
        yield from turn_to(vehicle, 0.0)
    return vehicle.telemetry().depth_m
"""


@pytest.fixture
def mission(tmp_path: Path) -> Path:
    path = tmp_path / "round.py"
    path.write_text(ROUND)
    return path


def short(vehicle):
    vehicle.undock()
    vehicle.log("diving")
    vehicle.set_effort(heave=-0.5)
    yield wait(4.0)
    return "deep"


def test_a_scenario_may_be_the_content_of_a_file_and_a_mission_must_be_one() -> None:
    content = {
        "name": "tank",
        "terrain": {"source": "noise", "size_m": [100, 100], "spacing_m": 5, "bed_depth_m": 8},
        "station": {"position_m": [0, 0, 0]},
        "vehicles": [{"name": "rov", "model": "rov"}],
    }
    assert uwsim.fly(short, content).result == "deep"
    with pytest.raises(ValueError, match=r"mission = \{'rov': .*: must be a function, .*; one of all vehicles takes"):
        uwsim.fly({"rov": short}, "pool")


def test_a_function_flies_in_memory_and_its_record_tells_everything() -> None:
    flown = uwsim.fly(short, "pool")
    assert flown.result == "deep"
    assert not flown.ended_early
    assert [event.name for event in flown.events][:3] == ["begun", "proximity_warning", "undock"]
    assert {"diving", "ended"} <= {event.name for event in flown.events}
    samples = flown.samples["rov"]
    assert flown.simulated_s == pytest.approx(4.0)
    assert samples["time_s"] == pytest.approx(np.arange(21) * 0.2)
    assert samples["depth_m"][-1] > samples["depth_m"][0] + 0.5
    assert (samples["altitude_m"] < 10.0).all()
    assert samples.lit_s("proximity") == pytest.approx(4.2), "the pool is shallow: lit at every sample"
    assert samples["effort heave"][-2] == -0.5


def test_a_flight_steps_as_the_simulator_alone_does() -> None:
    alone, flown = uwsim.Simulator("pool"), uwsim.Simulator("pool")
    alone.rov.undock()
    alone.rov.set_effort(heave=-0.5)
    alone.advance(4.0)
    alone.rov.set_effort()
    fly(short, flown, map=True)
    assert flown.save_state() == alone.save_state(), "neither samples nor pings disturb it"


@pytest.mark.usefixtures("blank_figures")
def test_the_command_writes_log_track_map_summary_and_report(mission: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = run_uwsim(
        "run", str(mission), "--scenario", "pool", "--map", "--set", "depth_m=3.0", "--out", str(out), "--seed", "3"
    )
    assert result.returncode == 0, result.stderr
    assert "the mission is complete" in result.stdout
    lines = [json.loads(line) for line in (out / "log.jsonl").read_text().splitlines()]
    assert [line["event"] for line in lines if line["vehicle"] == "rov" and line["event"] in ("undock", "out")] == [
        "undock",
        "out",
    ]
    values = json.loads((out / "summary.json").read_text())
    assert values["seed"] == 3
    assert values["vehicles"]["rov"]["depth_max_m"] == pytest.approx(3.0, abs=0.3)
    assert values["map"]["precision"] > 0.95
    assert len(OccupancyMap.read(out / "map.bt").occupied_voxels()) > 100
    track = np.genfromtxt(out / "track-rov.csv", delimiter=",", names=True)
    assert track["depth_m"].max() == pytest.approx(values["vehicles"]["rov"]["depth_max_m"], rel=1e-4)
    page = (out / "report.html").read_text()
    assert page.count("data:image/png;base64,") == 9
    assert "http" not in page.split("<body>")[1], "it needs nothing from elsewhere"
    assert not (out / "checkpoint").exists()


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("def mission(vehicle):\n    yield wait(1.0)\n", "m.py:2: NameError: name 'wait' is not defined (in mission)"),
        ("def mission(vehicle:\n", "m.py:1: '(' was never closed"),
        ("import nowhere\n", "m.py:1: ModuleNotFoundError: No module named 'nowhere'"),
        ("def misson(vehicle):\n    yield\n", "m.py: has no function 'mission'; did you mean 'misson'?"),
        ("x = 1\n", "m.py: has no function 'mission': write `def mission(vehicle): yield wait(1.0)`"),
        ("\ndef mission(vehicle):\n    pass\n", "m.py:2: mission: has no `yield`"),
        ("def mission(vehicle):\n    yield 0.1\n", "the mission yields 0.1: write `yield wait(seconds)`"),
        (
            "from uwsim.missions import goto\ndef mission(vehicle):\n    vehicle.undock()\n"
            "    yield from goto(vehicle, (1, 2))\n",
            "m.py:4: goto: position_world_m = [1.0, 2.0]: must be finite and of shape (3,), or (2,) with altitude_m",
        ),
        (
            "def mission(vehicle):\n    vehicle.sensors['sonr'].read()\n    yield\n",
            "m.py:2: rov.sensors['sonr']: must be one of",
        ),
        (
            "from uwsim.missions import goto, wait\ndef mission(vehicle):\n    yield wait(1.0)\n"
            "    goto(vehicle, (0.0, 0.0, -2.0))\n",
            "m.py:4: goto(...) is made and never run: write `yield from goto(...)`",
        ),
        ("\0", "m.py: source code string cannot contain null bytes"),
    ],
)
def test_a_mistake_is_one_line_with_file_and_line(text: str, words: str, tmp_path: Path) -> None:
    path = tmp_path / "m.py"
    path.write_text(text)
    with pytest.raises(MissionError) as caught:
        fly(path, "pool")
    assert words.replace("m.py", str(path)) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_mission_that_fails_leaves_its_results_and_exits_with_1(tmp_path: Path) -> None:
    path = tmp_path / "m.py"
    path.write_text("from uwsim.missions import wait\ndef mission(vehicle):\n    yield wait(2.0)\n    1 / 0\n")
    result = run_uwsim("run", str(path), "--scenario", "pool", "--out", str(tmp_path / "out"), "--report", "json")
    assert error_line(result).endswith("m.py:4: ZeroDivisionError: division by zero (in mission)")
    assert result.returncode == 1
    values = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert "ZeroDivisionError" in values["ended_because"]
    assert values["simulated_s"] == pytest.approx(2.0)


def test_a_mission_without_end_ends_at_its_time_limit() -> None:
    closed = []

    def mission(vehicle):
        try:
            while True:
                yield wait(0.03)
        finally:
            closed.append(vehicle.time_s)

    flown = fly(mission, "pool", time_limit_s=3.0)
    assert flown.simulated_s == pytest.approx(3.0)
    assert flown.ended_because == "the time limit of 3 s is over"
    assert not flown.ended_early, "that was asked for"
    assert closed == [pytest.approx(3.0)]
    flown = fly(mission, "pool", mission_time_s=2.0)
    assert flown.ended_because == BATTERY_EMPTY
    assert flown.ended_early


def test_waits_that_are_no_whole_steps_do_not_drift() -> None:
    def mission(vehicle):
        for _ in range(300):
            yield wait(0.0333)

    assert fly(mission, "pool").simulated_s == pytest.approx(300 * 0.0333, abs=0.005)


def test_a_mission_that_is_stuck_says_so() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield wait(1.0)
        raise StoppedError("stuck in the mud")

    flown = fly(mission, "pool")
    assert flown.ended_because == "stuck in the mud"
    assert flown.ended_early


class StopAfter(FlightAutosave):
    """Ask the flight to stop after a number of pauses, as Ctrl-C would."""

    def __init__(self, pauses: int) -> None:
        super().__init__(1e6)
        self.pauses = pauses

    def stop_requested(self) -> bool:
        self.pauses -= 1
        return self.pauses <= 0


@pytest.mark.parametrize("threads", [1, 2])
def test_a_resumed_flight_gives_the_same_map_track_and_log(mission: Path, tmp_path: Path, threads: int) -> None:
    whole = fly(mission, "pool", tmp_path / "whole", map=True, report="none")
    half = fly(mission, "pool", tmp_path / "half", map=True, report="none", threads=threads, autosave=StopAfter(150))
    assert half.interrupted
    assert 0 < len(half.all_pings_world_m) < len(whole.all_pings_world_m)
    again = resume(tmp_path / "half", threads=threads, report="none")
    assert again.result == whole.result
    assert again.echo_count == whole.echo_count
    assert again.map_growth == whole.map_growth and len(whole.map_growth) > 3
    for name in ("map.bt", "log.jsonl", "track-rov.csv", "track.npz"):
        assert (tmp_path / "half" / name).read_bytes() == (tmp_path / "whole" / name).read_bytes(), name
    assert not (tmp_path / "half" / "checkpoint").exists()
    with pytest.raises(ValueError, match="no unfinished flight"):
        resume(tmp_path / "half")


def test_a_killed_flight_is_resumed(mission: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    command = ["run", str(mission), "--scenario", "pool", "--map", "--out", str(out), "--autosave", "0.05"]
    process = subprocess.Popen([*UWSIM, *command, "--report", "none"], stderr=subprocess.PIPE, text=True)
    wait_for(out / "checkpoint" / "flight.json", process)
    process.kill()
    process.wait()
    result = run_uwsim("run", "--resume", "--out", str(out), "--report", "none")
    assert result.returncode == 0, result.stderr
    whole = fly(mission, "pool", map=True)
    assert whole.occupancy is not None
    assert (out / "map.bt").read_bytes() == whole.occupancy.to_bytes("bt")


def test_a_mission_that_has_changed_or_throws_dice_is_not_resumed(mission: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    fly(mission, "pool", out, report="none", autosave=StopAfter(60))
    mission.write_text(ROUND + "\n# other\n")
    with pytest.raises(ValueError, match="has changed since"):
        resume(out)
    mission.write_text(
        "import random\nfrom uwsim.missions import wait\n"
        "def mission(vehicle):\n    vehicle.undock()\n    while True:\n"
        "        vehicle.set_effort(surge=random.random())\n        yield wait(0.1)\n"
    )
    fly(mission, "pool", out, report="none", autosave=StopAfter(60))
    with pytest.raises(MissionError, match="does not fly as it did"):
        resume(out)


def test_two_vehicles_make_one_map_and_it_does_not_depend_on_threads() -> None:
    def mission(vehicles):
        first, second = vehicles["rov"], vehicles["scout"]
        first.undock()
        yield from parallel(goto(first, (-5.0, 8.0, -5.0)), turn_to(second, 0.0))
        second.log("done")

    flights = [fly(mission, "pair", map=True, threads=threads) for threads in (1, 2)]
    maps = [flown.occupancy.to_bytes("ot") for flown in flights]
    assert maps[0] == maps[1]
    assert flights[0].map_growth == flights[1].map_growth
    assert set(flights[0].pings_world_m) == {"rov", "scout"}
    alone = fly(lambda_goto, "pair", map=True, vehicles=["rov"])
    assert len(alone.occupancy.occupied_voxels()) < len(flights[0].occupancy.occupied_voxels())


def lambda_goto(vehicle):
    vehicle.undock()
    yield from goto(vehicle, (-5.0, 8.0, -5.0))


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"vehicles": ["rv"]}, "did you mean 'rov'"),
        ({"estimate": "wish"}, "estimate = 'wish': must be one of"),
        ({"report": "long"}, "report = 'long': must be one of"),
        ({"time_limit_s": 0.0}, "time_limit_s = 0.0 s: must be positive"),
        ({"arguments": {"depht_m": 3.0}}, "mission argument 'depht_m'"),
        ({"autosave_s": -1.0}, "autosave_s"),
    ],
)
def test_wrong_arguments_are_refused_before_anything_is_written(arguments: dict, words: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=words):
        fly(short, "pool", tmp_path / "out", **arguments)
    assert not (tmp_path / "out").exists()


def test_a_recorded_mission_replays_to_the_same_bytes(mission: Path, tmp_path: Path) -> None:
    file = tmp_path / "run.mcap"
    result = run_uwsim(
        "run", str(mission), "--scenario", "pool", "--out", str(tmp_path / "out"), "--report", "none",
        "--record", str(file), "--record-topic", "odom",
    )  # fmt: skip
    assert result.returncode == 0, result.stderr
    replayed = run_uwsim("replay", str(file))
    assert replayed.returncode == 0, replayed.stderr


def test_holding_a_place_keeps_it() -> None:
    def mission(vehicle):
        vehicle.undock()
        yield from goto(vehicle, (0.0, 3.0, -2.5))
        yield from hold(vehicle, 20.0)

    path = fly(mission, "pool").samples["rov"].path_world_m
    assert np.linalg.norm(path[-25:] - path[-1], axis=1).max() < 0.05


def test_what_a_link_carried_is_in_the_summary(tmp_path: Path) -> None:
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text() + "link: {modem: ideal_acoustic}\n"
    (tmp_path / "linked.yaml").write_text(text)
    sim = uwsim.Simulator(tmp_path / "linked.yaml")

    def mission(vehicle):
        for _ in range(3):
            sim.link.send("rov", "station", "hello", bytes(10))
            yield wait(0.5)

    fly(mission, sim, tmp_path / "out", report="json")
    (row,) = json.loads((tmp_path / "out" / "summary.json").read_text())["link"]
    assert (row["topic"], row["given"], row["delivered"], row["bytes_delivered"]) == ("hello", 3, 3, 30)
    assert 0.0 < row["delay_s"] < 0.01, "sound needs 4 ms for the six metres to the station"


def test_a_resumed_flight_has_the_link_that_it_was_given(mission: Path, tmp_path: Path) -> None:
    fly(mission, "pool", tmp_path / "whole", link="s2cm_hs", report="json")
    half = fly(mission, "pool", tmp_path / "half", link="s2cm_hs", report="json", autosave=StopAfter(150))
    assert half.interrupted
    resume(tmp_path / "half", report="json")
    whole, again = (json.loads((tmp_path / name / "summary.json").read_text())["link"] for name in ("whole", "half"))
    assert sum(row["delivered"] for row in whole) > 0
    assert again == whole
    with pytest.raises(ValueError, match="link: has no effect on an existing simulator"):
        fly(mission, uwsim.Simulator("pool"), link="tether")


def test_a_flight_by_the_filter_steers_and_maps_by_the_estimate(mission: Path, tmp_path: Path) -> None:
    true = fly(mission, "pool", map=True)
    flown = fly(mission, "pool", tmp_path / "out", map=True, estimate="filter", report="json")
    samples = flown.samples["rov"]
    off_m = np.linalg.norm(samples.estimated_path_world_m - samples.path_world_m, axis=1)
    assert 1e-3 < off_m.max() < 1.0
    assert (true.samples["rov"].estimated_path_world_m == true.samples["rov"].path_world_m).all()
    values = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert values["vehicles"]["rov"]["estimate_rms_m"] == pytest.approx(np.sqrt((off_m**2).mean()))
    pings_m = flown.pings_world_m["rov"]
    apart_m = np.linalg.norm(samples.estimated_path_world_m[:, None] - pings_m[None], axis=2).min(axis=0)
    assert np.median(apart_m) < 0.7, "the pings are where the vehicle thinks that it is, and the head on its hull"
    assert flown.occupancy.to_bytes("bt") != true.occupancy.to_bytes("bt")


def test_a_flight_by_the_filter_is_resumed_to_the_same_map(mission: Path, tmp_path: Path) -> None:
    whole = fly(mission, "pool", tmp_path / "whole", map=True, estimate="filter", report="none")
    assert whole.simulated_s > 15.0
    fly(mission, "pool", tmp_path / "half", map=True, estimate="filter", report="none", autosave=StopAfter(150))
    resume(tmp_path / "half", report="none")
    assert (tmp_path / "half" / "map.bt").read_bytes() == (tmp_path / "whole" / "map.bt").read_bytes()


def test_a_mission_that_ends_at_once_has_a_report(tmp_path: Path) -> None:
    def mission(vehicle):
        return 3
        yield

    flown = fly(mission, "pool", tmp_path, map=True)
    assert flown.result == 3
    assert flown.simulated_s == 0.0
    assert (tmp_path / "report.html").exists()
    assert (tmp_path / "map.bt").exists()


def test_ctrl_c_ends_a_flight_with_its_results_and_it_can_be_resumed(tmp_path: Path) -> None:
    path, out = tmp_path / "long.py", tmp_path / "out"
    path.write_text(
        "from uwsim.missions import hold\ndef mission(vehicle):\n    vehicle.undock()\n    yield from hold(vehicle)\n"
    )
    options = ["--scenario", "pool", "--mission-time", "100000", "--report", "json", "--out", str(out)]
    process = subprocess.Popen([*UWSIM, "run", str(path), *options], stderr=subprocess.PIPE, text=True)
    wait_for(out / "log.jsonl", process)
    time.sleep(0.5)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert "Traceback" not in errors
    assert "interrupted" in json.loads((out / "summary.json").read_text())["ended_because"]
    assert (out / "checkpoint" / "flight.json").exists()
