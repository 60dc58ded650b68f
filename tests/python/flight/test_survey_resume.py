"""A survey that is killed at any time and resumed produces the same map as an uninterrupted one."""

import hashlib
import json
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from command_line import start_survey
from stopped_flights import StopAfter
from uwsim import Simulator
from uwsim.base.atomic_file import write_atomically
from uwsim.flight.fly import fly, resume
from uwsim.flight.record import DONE, FlightRecord
from uwsim.flight.request import FlightRequest
from uwsim.flight.survey import fly_survey, resume_survey, run_survey
from uwsim.mapping import OccupancyMap
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario


@pytest.fixture(autouse=True)
def no_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the results: they take longer than the flights and are tested elsewhere."""
    monkeypatch.setattr("uwsim.flight.engine.write_results", only_the_map)


def only_the_map(flown: FlightRecord, sim: object, out: Path, *arguments: object, **more: object) -> FlightRecord:
    flown.occupancy.write(out / "map.bt")
    return flown


def survey(out: Path, scenario: object = "pool", **options: object) -> FlightRecord:
    return fly(None, scenario, out, map=True, map_growth=False, sample_sensors=False, **options)


@pytest.mark.parametrize(("pauses", "threads"), [((1,), 1), ((*range(1, 150, 20), 151), 2)])
def test_a_survey_resumed_from_any_pause_is_the_same(
    pauses: tuple[int, ...], threads: int, small_pool: Path, surveyed: tuple[FlightRecord, Path], tmp_path: Path
) -> None:
    stopped = survey(tmp_path, small_pool, threads=threads, autosave=StopAfter(*pauses))
    assert stopped.interrupted
    record, (expected, _) = resume(tmp_path), surveyed
    assert record.occupancy.to_bytes("ot") == expected.occupancy.to_bytes("ot"), "all log-odds"
    np.testing.assert_array_equal(record.path_world_m, expected.path_world_m)
    for name in ("simulated_s", "ping_count", "echo_count", "collisions", "ended_because", "result"):
        assert getattr(record, name) == getattr(expected, name)
    np.testing.assert_array_equal(record.sample_ping.ranges_m, expected.sample_ping.ranges_m)
    np.testing.assert_array_equal(record.samples["rov"].values, expected.samples["rov"].values)
    assert record.events == expected.events, "each once"
    assert record.wall_s > stopped.wall_s - 0.5, "wall time of both flights"


def test_a_ping_rate_out_of_step_with_the_control_period_is_resumed(tmp_path: Path) -> None:
    pool = load("pool")
    odd = pool.model_copy(update={"survey": pool.survey.model_copy(update={"ping_rate_hz": 7.0})})
    write_scenario(tmp_path / "odd.yaml", odd)
    whole, _ = fly_survey(Simulator(tmp_path / "odd.yaml", mission_time_s=7.0))
    survey(tmp_path, tmp_path / "odd.yaml", mission_time_s=7.0, autosave=StopAfter(31))
    assert resume(tmp_path).occupancy.to_bytes("ot") == whole.to_bytes("ot")


def test_saving_does_not_change_the_map(small_pool: Path, surveyed: tuple[FlightRecord, Path], tmp_path: Path) -> None:
    flown = survey(tmp_path, small_pool, threads=2, autosave=StopAfter(*range(1, 700, 20), 10_000))
    assert flown.occupancy.to_bytes("ot") == surveyed[0].occupancy.to_bytes("ot")


def saved_state(out: Path) -> bytes | None:
    try:
        return (out / "checkpoint" / "flight.json").read_bytes()
    except FileNotFoundError:
        return None


def test_a_survey_killed_several_times_ends_with_the_same_map(small_pool: Path, tmp_path: Path) -> None:
    """At 0.1 m, so that a good part of the time is spent saving, when the process may be killed."""
    options = (str(small_pool), "--voxel", "0.1", "--seed", "3", "--report", "json")
    run_survey(small_pool, tmp_path / "whole", voxel_m=0.1, seed=3, autosave_s=0.0)
    expected = hashlib.sha256((tmp_path / "whole" / "map.bt").read_bytes()).hexdigest()
    out = tmp_path / "out"
    process = start_survey(out, *options)
    killed = 0
    for after_s in (0.0, 0.23):
        before = saved_state(out)
        while process.poll() is None and saved_state(out) == before:  # until another save is complete
            time.sleep(0.01)
        time.sleep(after_s)
        process.kill()
        process.communicate()
        if saved_state(out) is None:  # it has finished, or was removing its saved state
            break
        killed += 1
        OccupancyMap.read(out / "map.bt")  # raises an error if the file is damaged
        process = start_survey(out, "--resume", "--report", "json")
    else:
        output, errors = process.communicate(timeout=600)
        assert process.returncode == 0, errors
        assert DONE in output
    assert killed >= 1
    assert hashlib.sha256((out / "map.bt").read_bytes()).hexdigest() == expected
    if process.returncode == 0:
        suffixes = {path.suffix for path in out.iterdir()}
        assert suffixes == {".bt", ".json", ".jsonl", ".csv", ".npz"}, "no leftovers"


def test_temporary_files_are_removed_even_if_the_process_was_killed_before_it_marked_them(tmp_path: Path) -> None:
    folder = saved_pool(tmp_path)
    (folder / ".uwsim-4194305-0.tmp").touch()  # larger than any process ID
    (folder / ".flight-7.npz.abc_1234").touch()
    (folder / ".flight-8.npz.abc_1234").write_bytes(b"foreign")
    resume(tmp_path)
    assert [path.name for path in folder.iterdir()] == [".flight-8.npz.abc_1234"]


def test_results_of_an_earlier_survey_are_removed(tmp_path: Path) -> None:
    earlier = [tmp_path / name for name in ("track.npz", "report.html", "map_from_above.png")]
    for path in earlier:
        write_atomically(path, b"of an earlier survey")
    run_survey("pool", tmp_path, mission_time_s=1.0)  # results are skipped, see no_results
    assert not any(path.exists() for path in earlier)


def saved_pool(out: Path, pause: int = 30) -> Path:
    survey(out, seed=0, mission_time_s=4.0, autosave=StopAfter(pause))
    return out / "checkpoint"


def test_a_survey_that_cannot_be_resumed_says_why(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no unfinished flight is saved in '.*': the folder holds no flight"):
        resume_survey(tmp_path)
    assert not any(tmp_path.iterdir())
    run_survey("pool", tmp_path, mission_time_s=3.0, autosave_s=0.01)
    with pytest.raises(ValueError, match=r"its map\.bt belongs to a flight that has ended"):
        resume_survey(tmp_path)
    saved_pool(tmp_path)
    with pytest.raises(ValueError, match="seed = 9: the flight was started with 0"):
        resume_survey(tmp_path, seed=9)
    with pytest.raises(ValueError, match="scenario = lake: the flight was started with pool"):
        resume_survey(tmp_path, scenario="lake")
    with pytest.raises(ValueError, match="link = tether: the flight was started with s2cm_hs"):
        FlightRequest(scenario="pool", link="s2cm_hs").require_same({"link": "tether"})


def damaged_copies(path: Path) -> Iterator[bytes]:
    whole = path.read_bytes()
    yield b""
    yield whole[: len(whole) // 2]
    yield whole[:-1]
    yield b"x" + whole[1:]
    middle = len(whole) // 3
    yield whole[:middle] + bytes([whole[middle] ^ 4]) + whole[middle + 1 :]


def test_a_damaged_checkpoint_is_refused(tmp_path: Path) -> None:
    checkpoint = saved_pool(tmp_path)
    (saved_map,), (arrays,) = checkpoint.glob("map-*.ot"), checkpoint.glob("flight-*.npz")
    for path in (checkpoint / "flight.json", saved_map, arrays):
        whole = path.read_bytes()
        for damaged in damaged_copies(path):
            path.write_bytes(damaged)
            with pytest.raises(ValueError, match=r"--resume: '.*'"):
                resume_survey(tmp_path)
        path.write_bytes(whole)
    saved_map.unlink()
    with pytest.raises(ValueError, match=r"map-\d+\.ot': is missing"):
        resume_survey(tmp_path)


def test_another_survey_in_the_same_folder_sets_the_unfinished_one_aside(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    saved_pool(tmp_path)
    run_survey("pool", tmp_path, mission_time_s=3.0)
    assert "an unfinished flight was in" in capfd.readouterr().err
    assert (tmp_path / "checkpoint.old" / "flight.json").exists()
    assert not (tmp_path / "checkpoint").exists()


HOVER = """
class Hover:
    progress = 0.0

    def __init__(self, vehicle, clock, plan):
        self.clock = clock

    def run(self):
        for _ in range(60):
            self.clock.wait(0.1)
        return "hovered"
"""


def test_a_mission_without_save_and_restore_is_flown_again_as_far_as_it_was(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "hovering.py").write_text(HOVER)
    monkeypatch.chdir(tmp_path)
    mission = "hovering:Hover"
    whole = fly(mission, "pool", tmp_path / "whole", map=True)
    assert whole.ended_because == "hovered" and whole.ended_early
    half = fly(mission, "pool", tmp_path / "half", map=True, autosave=StopAfter(15))
    assert half.interrupted and 0 < half.ping_count < whole.ping_count
    again = resume(tmp_path / "half")
    assert again.occupancy.to_bytes("ot") == whole.occupancy.to_bytes("ot")
    assert again.ended_because == "hovered"
    assert again.map_growth == whole.map_growth


ZIGZAG = """
from uwsim.missions import wait

class Zigzag:
    def __init__(self, vehicle):
        self.vehicle, self.left = vehicle, 30

    def steps(self):
        if not self.vehicle.released:
            self.vehicle.undock()
        while self.left:
            self.vehicle.set_effort(surge=0.4, yaw=0.1 if self.left % 2 else -0.1)
            self.left -= 1
            yield wait(0.25)
        return "all legs are flown"

    def save(self):
        return {"left": self.left}

    def restore(self, state):
        assert self.left == 30
        self.left = state["left"]
"""


def test_a_mission_with_save_and_restore_continues_from_its_state(tmp_path: Path) -> None:
    file = tmp_path / "zigzag.py"
    file.write_text(ZIGZAG)
    whole = fly(file, "pool", tmp_path / "whole", function="Zigzag", map=True)
    half = tmp_path / "half"
    assert fly(file, "pool", half, function="Zigzag", map=True, autosave=StopAfter(13)).interrupted
    assert json.loads((half / "checkpoint" / "flight.json").read_bytes())["mission"]["state"] == {"left": 17}
    again = resume(half)
    assert again.result == whole.result == "all legs are flown"
    assert again.occupancy.to_bytes("ot") == whole.occupancy.to_bytes("ot")
    assert (again.events, again.map_growth) == (whole.events, whole.map_growth)
    np.testing.assert_array_equal(again.samples["rov"].values, whole.samples["rov"].values)


def test_an_invalid_autosave_interval_is_refused(tmp_path: Path) -> None:
    for seconds in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match=r"autosave_s = .*: must be 0"):
            run_survey("pool", tmp_path / "out", autosave_s=seconds)
    assert not any(tmp_path.iterdir())


def test_a_map_in_limited_memory_is_the_same_and_verified_even_when_resumed(tmp_path: Path) -> None:
    """At 0.05 m the pool's map exceeds the limit."""
    options = {"voxel_m": 0.05, "mission_time_s": 8.0}
    assert run_survey("pool", tmp_path / "whole", **options).verified is None
    out = tmp_path / "out"
    survey(out, verify_map=True, autosave=StopAfter(40), **options)
    assert list((out / "checkpoint").glob("reference-*.ot"))
    assert resume_survey(out).verified is True
    assert (out / "map.bt").read_bytes() == (tmp_path / "whole" / "map.bt").read_bytes()
