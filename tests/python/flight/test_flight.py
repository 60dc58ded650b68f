"""Mission flights: their records, and how they end."""

import json
import signal
import subprocess
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import UWSIM, error_line, hears_ctrl_c, wait_for
from command_line import uwsim as run_uwsim
from uwsim.flight.fly import fly
from uwsim.flight.mission_file import MissionError
from uwsim.flight.record import BATTERY_EMPTY, FlightRecord
from uwsim.mapping import OccupancyMap
from uwsim.missions import parallel, turn_to, wait

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


@pytest.mark.usefixtures("blank_figures")
def test_a_scenario_may_be_the_content_of_a_file_and_a_mission_must_be_one(tmp_path: Path) -> None:
    def at_once(vehicle):
        return 3
        yield

    content = {
        "name": "tank",
        "terrain": {"source": "noise", "size_m": [100, 100], "spacing_m": 5, "bed_depth_m": 8},
        "station": {"position_m": [0, 0, 0]},
        "vehicles": [{"name": "rov", "model": "rov"}],
    }
    flown = uwsim.fly(at_once, content, tmp_path, map=True)
    assert (flown.result, flown.simulated_s) == (3, 0.0)
    assert (tmp_path / "report.html").exists() and (tmp_path / "map.bt").exists()
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
def test_the_command_writes_all_results_and_a_recording_that_replays(mission: Path, tmp_path: Path) -> None:
    out = tmp_path / "out"
    result = run_uwsim(
        "run", mission, "--scenario", "pool", "--map", "--set", "depth_m=3.0", "--out", out, "--seed", "3",
        "--record", tmp_path / "run.mcap", "--record-topic", "odom",
    )  # fmt: skip
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
    replayed = run_uwsim("replay", tmp_path / "run.mcap")
    assert replayed.returncode == 0, replayed.stderr


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


CARRIED = {"estimate": "filter", "link": "s2cm_hs"}


@pytest.fixture(scope="module")
def carried(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, FlightRecord, Path]:
    """Return a mission's file, the record of its flight by the filter and over a link, and its folder."""
    folder = tmp_path_factory.mktemp("carried")
    (folder / "round.py").write_text(ROUND)
    whole = fly(folder / "round.py", "pool", folder / "whole", map=True, report="json", **CARRIED)
    return folder / "round.py", whole, folder / "whole"


def test_a_link_has_no_effect_on_an_existing_simulator(carried) -> None:
    mission, whole, _ = carried
    assert len(whole.map_growth) > 3
    with pytest.raises(ValueError, match="link: has no effect on an existing simulator"):
        fly(mission, uwsim.Simulator("pool"), link="tether")


def test_a_flight_by_the_filter_steers_and_maps_by_the_estimate(carried) -> None:
    mission, flown, out = carried
    true = fly(mission, "pool", map=True)
    samples = flown.samples["rov"]
    off_m = np.linalg.norm(samples.estimated_path_world_m - samples.path_world_m, axis=1)
    assert 1e-3 < off_m.max() < 1.0
    assert (true.samples["rov"].estimated_path_world_m == true.samples["rov"].path_world_m).all()
    values = json.loads((out / "summary.json").read_text())
    assert values["vehicles"]["rov"]["estimate_rms_m"] == pytest.approx(np.sqrt((off_m**2).mean()))
    pings_m = flown.pings_world_m["rov"]
    assert len(flown.position_error_m) == len(pings_m) and 0.0 < flown.position_error_m.max() < 1.0
    apart_m = np.linalg.norm(samples.estimated_path_world_m[:, None] - pings_m[None], axis=2).min(axis=0)
    assert np.median(apart_m) < 0.7, "the pings are where the vehicle thinks that it is, and the head on its hull"
    assert flown.occupancy.to_bytes("bt") != true.occupancy.to_bytes("bt")


def test_two_vehicles_make_one_map_and_it_does_not_depend_on_threads() -> None:
    def out(vehicle):
        vehicle.undock()
        yield wait(6.0)

    def mission(vehicles):
        yield from parallel(out(vehicles["rov"]), turn_to(vehicles["scout"], 0.0))

    flights = [fly(mission, "pair", map=True, threads=threads, time_limit_s=6.0) for threads in (1, 2)]
    maps = [flown.occupancy.to_bytes("ot") for flown in flights]
    assert maps[0] == maps[1]
    assert flights[0].map_growth == flights[1].map_growth
    assert set(flights[0].pings_world_m) == {"rov", "scout"}
    alone = fly(out, "pair", map=True, vehicles=["rov"], time_limit_s=6.0)
    assert len(alone.occupancy.occupied_voxels()) < len(flights[0].occupancy.occupied_voxels())


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


def test_ctrl_c_ends_a_flight_with_its_results(carried, tmp_path: Path) -> None:
    mission, _, _ = carried
    options = ["--estimate", "filter", "--link", "s2cm_hs", "--autosave", "0.05", "--report", "json"]
    command = [*UWSIM, "run", mission, "--scenario", "pool", "--map", "--out", tmp_path / "out", *options]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, preexec_fn=hears_ctrl_c)
    wait_for(tmp_path / "out" / "map.bt", process)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=600)
    assert process.returncode == 130, errors
    assert "holds everything flown so far" in " ".join(errors.split()) and "Traceback" not in errors
    assert "interrupted" in json.loads((tmp_path / "out" / "summary.json").read_text())["ended_because"]
    OccupancyMap.read(tmp_path / "out" / "map.bt")
