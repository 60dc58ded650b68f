"""A survey that is killed at any moment and resumed ends with the same map as an uninterrupted one."""

import hashlib
import signal
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from command_line import start_survey, wait_for
from uwsim import Simulator
from uwsim.mapping import OccupancyMap
from uwsim.scenario import load
from uwsim.survey.checkpoint import Checkpoint
from uwsim.survey.fly import fly_survey
from uwsim.survey.record import INTERRUPTED
from uwsim.survey.request import SurveyRequest
from uwsim.survey.run import resume_survey, run_survey

REQUEST = SurveyRequest("pool", 0, None, None, None, 0.5, "bricks", False)


@pytest.fixture(autouse=True)
def no_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the results: they take longer than the flights, and other tests cover them."""
    monkeypatch.setattr("uwsim.survey.run.write_results", lambda *arguments: None)


class SaveAt:
    """A flight supervisor that saves the flight at the given pauses, counted from 1, and stops it at the last."""

    def __init__(self, checkpoint: Checkpoint, *pauses: int) -> None:
        self.checkpoint = checkpoint
        self.pauses = pauses
        self.count = 0

    def save_due(self) -> bool:
        self.count += 1
        return self.count in self.pauses

    def stop_requested(self) -> bool:
        return self.count + 1 == self.pauses[-1]

    def save(self, state: object, occupancy: OccupancyMap, reference: OccupancyMap | None) -> None:
        self.checkpoint.write(REQUEST, state, occupancy, reference)


@pytest.fixture(scope="module")
def uninterrupted() -> tuple[bytes, object]:
    occupancy, record = fly_survey(Simulator("pool"))
    return occupancy.to_bytes("ot"), record


@pytest.mark.parametrize(("pause", "threads"), [(1, 1), (150, 2), (333, 1), (600, 2)])
def test_a_survey_resumed_from_any_pause_is_the_same(
    pause: int, threads: int, uninterrupted: tuple[bytes, object], tmp_path: Path
) -> None:
    checkpoint = Checkpoint(tmp_path)
    supervisor = SaveAt(checkpoint, pause)
    _, stopped = fly_survey(Simulator("pool", threads=threads), supervisor=supervisor)
    assert stopped.stopped_because == INTERRUPTED
    saved = checkpoint.read()
    occupancy, record = fly_survey(Simulator("pool"), saved.occupancy, resume=saved.state)
    expected_map, expected = uninterrupted
    assert occupancy.to_bytes("ot") == expected_map, "all log-odds"
    np.testing.assert_array_equal(record.path_world_m, expected.path_world_m)
    for name in ("simulated_s", "ping_count", "echo_count", "collision_count", "stopped_because"):
        assert getattr(record, name) == getattr(expected, name)
    np.testing.assert_array_equal(record.sample_ping.ranges_m, expected.sample_ping.ranges_m)
    assert record.wall_s > stopped.wall_s - 0.5, "wall time of both flights"


def test_a_ping_rate_out_of_step_with_the_control_period_is_resumed(tmp_path: Path) -> None:
    pool = load("pool")
    odd = pool.model_copy(update={"survey": pool.survey.model_copy(update={"ping_rate_hz": 7.0})})
    whole, _ = fly_survey(Simulator(odd, mission_time_s=12.0))
    fly_survey(Simulator(odd, mission_time_s=12.0), supervisor=SaveAt(Checkpoint(tmp_path), 51))
    saved = Checkpoint(tmp_path).read()
    occupancy, _ = fly_survey(Simulator(odd, mission_time_s=12.0), saved.occupancy, resume=saved.state)
    assert occupancy.to_bytes("ot") == whole.to_bytes("ot")


def test_saving_does_not_change_the_map(uninterrupted: tuple[bytes, object], tmp_path: Path) -> None:
    supervisor = SaveAt(Checkpoint(tmp_path), *range(1, 700, 20), 10_000)
    occupancy, _ = fly_survey(Simulator("pool", threads=2), supervisor=supervisor)
    assert occupancy.to_bytes("ot") == uninterrupted[0]


def saved_state(out: Path) -> bytes | None:
    try:
        return (out / "checkpoint" / "survey.state").read_bytes()
    except FileNotFoundError:
        return None


def test_a_survey_killed_several_times_ends_with_the_same_map(tmp_path: Path) -> None:
    """At 0.1 m, so that saving takes a good part of the time in which it may be killed."""
    options = ("pool", "--voxel", "0.1", "--seed", "3")
    run_survey("pool", tmp_path / "whole", voxel_m=0.1, seed=3, autosave_s=0.0)
    expected = hashlib.sha256((tmp_path / "whole" / "map.bt").read_bytes()).hexdigest()
    out = tmp_path / "out"
    process = start_survey(out, *options)
    killed = 0
    for after_s in (0.0, 0.17, 0.37):
        before = saved_state(out)
        while process.poll() is None and saved_state(out) == before:  # until another save is done
            time.sleep(0.01)
        time.sleep(after_s)
        process.kill()
        if process.wait() == 0:  # it has ended before
            break
        process.communicate()
        killed += 1
        OccupancyMap.read(out / "map.bt")  # raises if it is damaged
        process = start_survey(out, "--resume")
    assert killed >= 1
    output, errors = process.communicate(timeout=600)
    assert process.returncode == 0, errors
    assert "all lanes are flown" in output
    assert hashlib.sha256((out / "map.bt").read_bytes()).hexdigest() == expected
    assert {path.suffix for path in out.iterdir()} == {".bt", ".html", ".json", ".npz", ".png"}, "no leftovers"


@pytest.mark.parametrize("name", ["track.npz", "report.html", "map_from_above.png"])
def test_results_of_an_earlier_survey_are_removed(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"of an earlier survey")
    run_survey("pool", tmp_path, mission_time_s=1.0)  # the results are skipped here, see no_results
    assert not (tmp_path / name).exists()


def test_ctrl_c_saves_before_it_ends(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start_survey(out, "pool")
    wait_for(out / "checkpoint" / "survey.state", process)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=90)
    assert process.returncode == 130, errors
    assert "--resume continues" in " ".join(errors.split())
    record = resume_survey(out)
    assert record.stopped_because == "all lanes are flown"
    expected = fly_survey(Simulator("pool"))[0].to_bytes("bt")
    assert (out / "map.bt").read_bytes() == expected


def saved_pool(out: Path, pause: int = 30) -> Checkpoint:
    out.mkdir(exist_ok=True)
    fly_survey(Simulator("pool"), supervisor=SaveAt(Checkpoint(out), pause))
    return Checkpoint(out)


def test_a_survey_that_cannot_be_resumed_says_why(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no unfinished survey is saved in '.*': the folder holds no survey"):
        resume_survey(tmp_path)
    assert not any(tmp_path.iterdir())
    run_survey("pool", tmp_path, mission_time_s=3.0, autosave_s=0.01)
    with pytest.raises(ValueError, match=r"its map\.bt belongs to a survey that has ended"):
        resume_survey(tmp_path)
    saved_pool(tmp_path)
    with pytest.raises(ValueError, match="seed = 9: the survey was begun with 0"):
        resume_survey(tmp_path, seed=9)
    with pytest.raises(ValueError, match="scenario = lake: the survey was begun with pool"):
        resume_survey(tmp_path, scenario="lake")


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
    (saved_map,) = checkpoint.folder.glob("map-*.ot")
    for path in (checkpoint.folder / "survey.state", saved_map):
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
    assert "an unfinished survey was in" in capfd.readouterr().err
    assert (tmp_path / "checkpoint.old" / "survey.state").exists()
    assert not (tmp_path / "checkpoint").exists()


def test_a_mission_without_save_and_restore_flies_but_cannot_be_resumed(tmp_path: Path) -> None:
    class Hover:
        progress = 0.0

        def __init__(self, vehicle: object, clock: object, plan: object) -> None:
            self.clock = clock

        def run(self) -> str:
            for _ in range(10):
                self.clock.wait(0.1)
            return "hovered"

    _, record = fly_survey(Simulator("pool"), mission=Hover, supervisor=SaveAt(Checkpoint(tmp_path), 5, 99))
    assert record.stopped_because == "hovered"
    saved = Checkpoint(tmp_path).read()
    with pytest.raises(ValueError, match="mission Hover: cannot be resumed: it has no save and restore"):
        fly_survey(Simulator("pool"), saved.occupancy, mission=Hover, resume=saved.state)


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf")])
def test_an_invalid_autosave_interval_is_refused(seconds: float, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"autosave_s = .*: must be 0"):
        run_survey("pool", tmp_path / "out", autosave_s=seconds)
    assert not any(tmp_path.iterdir())


def test_a_map_in_limited_memory_is_the_same_even_when_resumed(tmp_path: Path) -> None:
    """At 0.05 m the pool's map exceeds the limit."""
    options = {"voxel_m": 0.05, "mission_time_s": 12.0}
    run_survey("pool", tmp_path / "whole", **options)
    out = tmp_path / "out"
    limited = ("pool", "--voxel", "0.05", "--mission-time", "12", "--map-memory", "2")
    process = start_survey(out, *limited)
    wait_for(out / "checkpoint" / "survey.state", process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    resume_survey(out, map_memory_mb=2.0)
    assert (out / "map.bt").read_bytes() == (tmp_path / "whole" / "map.bt").read_bytes()
