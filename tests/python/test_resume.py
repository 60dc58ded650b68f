"""A survey that is killed, wherever, and resumed ends with the map of one that was not."""

import hashlib
import resource
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.mapping import OccupancyMap
from uwsim.scenario import load
from uwsim.survey.autosave import Autosave
from uwsim.survey.checkpoint import Checkpoint, SurveyOrder
from uwsim.survey.command import resume_survey, run_survey
from uwsim.survey.fly import fly_survey
from uwsim.survey.record import INTERRUPTED

UWSIM = [sys.executable, "-c", "from uwsim.cli import main; main()"]
ORDER = SurveyOrder("pool", 0, None, None, None, 0.5, "bricks", False)


@pytest.fixture(autouse=True)
def no_pictures(monkeypatch: pytest.MonkeyPatch) -> None:
    """They take longer than the flights, and are tested elsewhere."""
    monkeypatch.setattr("uwsim.survey.command._report", lambda *anything: None)


class SaveAt:
    """Watches a flight: saves it at these of its pauses, and stops it at the last of them."""

    def __init__(self, checkpoint: Checkpoint, *pauses: int) -> None:
        self.checkpoint = checkpoint
        self.pauses = pauses
        self.count = 0

    def save_due(self) -> bool:
        self.count += 1
        return self.count in self.pauses

    def stopping(self) -> bool:
        return self.count + 1 == self.pauses[-1]

    def save(self, state: object, occupancy: OccupancyMap, reference: OccupancyMap | None) -> None:
        self.checkpoint.write(ORDER, state, occupancy, reference)


@pytest.fixture(scope="module")
def whole() -> tuple[bytes, object]:
    occupancy, record = fly_survey(Simulator("pool"))
    return occupancy.to_bytes("ot"), record


@pytest.mark.parametrize(("pause", "threads"), [(1, 1), (150, 2), (333, 1), (600, 2)])
def test_from_any_pause_on_the_survey_is_the_same(
    pause: int, threads: int, whole: tuple[bytes, object], tmp_path: Path
) -> None:
    checkpoint = Checkpoint(tmp_path)
    watch = SaveAt(checkpoint, pause)
    _, stopped = fly_survey(Simulator("pool", threads=threads), watch=watch)
    assert stopped.stopped_because == INTERRUPTED
    saved = checkpoint.read()
    occupancy, record = fly_survey(Simulator("pool"), saved.occupancy, resume=saved.state)
    expected, uninterrupted = whole
    assert occupancy.to_bytes("ot") == expected, "all log-odds"
    np.testing.assert_array_equal(record.path_world_m, uninterrupted.path_world_m)
    for name in ("simulated_s", "ping_count", "echo_count", "collision_count", "stopped_because"):
        assert getattr(record, name) == getattr(uninterrupted, name)
    np.testing.assert_array_equal(record.sample_ping.ranges_m, uninterrupted.sample_ping.ranges_m)
    assert record.wall_s > stopped.wall_s - 0.5, "wall time of both flights"


def test_a_ping_rate_beside_the_control_period_is_kept(tmp_path: Path) -> None:
    pool = load("pool")
    odd = pool.model_copy(update={"survey": pool.survey.model_copy(update={"ping_rate_hz": 7.0})})
    whole, _ = fly_survey(Simulator(odd, mission_time_s=12.0))
    fly_survey(Simulator(odd, mission_time_s=12.0), watch=SaveAt(Checkpoint(tmp_path), 51))
    saved = Checkpoint(tmp_path).read()
    occupancy, _ = fly_survey(Simulator(odd, mission_time_s=12.0), saved.occupancy, resume=saved.state)
    assert occupancy.to_bytes("ot") == whole.to_bytes("ot")


def test_saving_does_not_change_the_map(whole: tuple[bytes, object], tmp_path: Path) -> None:
    watch = SaveAt(Checkpoint(tmp_path), *range(1, 700, 20), 10_000)
    occupancy, _ = fly_survey(Simulator("pool", threads=2), watch=watch)
    assert occupancy.to_bytes("ot") == whole[0]


def start(out: Path, *options: str) -> subprocess.Popen[str]:
    command = [*UWSIM, "survey", *options, "--out", str(out), "--autosave", "0.05"]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def wait_for(path: Path, process: subprocess.Popen[str]) -> None:
    while not path.exists():
        assert process.poll() is None, process.communicate()
        time.sleep(0.01)


def saved_state(out: Path) -> bytes | None:
    try:
        return (out / "checkpoint" / "survey.state").read_bytes()
    except FileNotFoundError:
        return None


def test_kill_9_at_any_moment_and_again_and_again(tmp_path: Path) -> None:
    """At 0.1 m, so that writing is a good part of the time that may be hit."""
    options = ("pool", "--voxel", "0.1", "--seed", "3")
    run_survey("pool", tmp_path / "whole", voxel_m=0.1, seed=3, autosave_s=0.0)
    expected = hashlib.sha256((tmp_path / "whole" / "map.bt").read_bytes()).hexdigest()
    out = tmp_path / "out"
    process = start(out, *options)
    killed = 0
    for after_s in (0.0, 0.13, 0.29, 0.41):
        before = saved_state(out)
        while process.poll() is None and saved_state(out) == before:  # until it has flown on
            time.sleep(0.01)
        time.sleep(after_s)
        process.kill()
        if process.wait() == 0:  # it was quicker
            break
        process.communicate()
        killed += 1
        OccupancyMap.read(out / "map.bt")  # raises unless it is whole
        process = start(out, "--resume")
    assert killed >= 1
    output, errors = process.communicate(timeout=120)
    assert process.returncode == 0, errors
    assert "all lanes are flown" in output
    assert hashlib.sha256((out / "map.bt").read_bytes()).hexdigest() == expected
    assert {path.suffix for path in out.iterdir()} == {".bt", ".html", ".npz", ".png"}, "no leftovers"


def test_a_report_that_could_not_be_made_is_made_by_resume(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made: list[object] = []

    def full(*anything: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr("uwsim.survey.command._report", full)
    with pytest.raises(OSError, match=r"No space left.*map\.bt is complete; uwsim survey --resume makes the report"):
        run_survey("pool", tmp_path, mission_time_s=5.0)
    flown = (tmp_path / "map.bt").read_bytes()
    monkeypatch.setattr("uwsim.survey.command._report", lambda sim, occupancy, record, *more: made.append(record))
    record = resume_survey(tmp_path)
    assert made == [record]
    assert (tmp_path / "map.bt").read_bytes() == flown
    assert {path.name for path in tmp_path.iterdir()} == {"map.bt"}


@pytest.mark.parametrize("name", ["track.npz", "report.html", "map_from_above.png"])
def test_what_an_earlier_survey_said_does_not_lie_beside_the_map_of_another(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_bytes(b"of another flight")
    run_survey("pool", tmp_path, mission_time_s=1.0)  # the report, which writes them, is left out here
    assert not (tmp_path / name).exists()


def test_ctrl_c_saves_before_it_ends(tmp_path: Path) -> None:
    out = tmp_path / "out"
    process = start(out, "pool")
    wait_for(out / "checkpoint" / "survey.state", process)
    process.send_signal(signal.SIGINT)
    _, errors = process.communicate(timeout=90)
    assert process.returncode == 130, errors
    assert "--resume flies on" in " ".join(errors.split())
    record = resume_survey(out)
    assert record.stopped_because == "all lanes are flown"
    expected = fly_survey(Simulator("pool"))[0].to_bytes("bt")
    assert (out / "map.bt").read_bytes() == expected


def saved_pool(out: Path, pause: int = 30) -> Checkpoint:
    out.mkdir(exist_ok=True)
    fly_survey(Simulator("pool"), watch=SaveAt(Checkpoint(out), pause))
    return Checkpoint(out)


def test_what_cannot_be_resumed_says_why(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no unfinished survey is saved in '.*': nothing is in it"):
        resume_survey(tmp_path)
    assert not any(tmp_path.iterdir())
    run_survey("pool", tmp_path, mission_time_s=3.0, autosave_s=0.01)
    with pytest.raises(ValueError, match=r"map\.bt in it is of a survey that has ended"):
        resume_survey(tmp_path)
    saved_pool(tmp_path)
    with pytest.raises(ValueError, match="seed = 9: the survey was begun with 0"):
        resume_survey(tmp_path, seed=9)
    with pytest.raises(ValueError, match="scenario = lake: the survey was begun with pool"):
        resume_survey(tmp_path, scenario="lake")


def damages(path: Path) -> Iterator[bytes]:
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
        for damaged in damages(path):
            path.write_bytes(damaged)
            with pytest.raises(ValueError, match=r"--resume: '.*'"):
                resume_survey(tmp_path)
        path.write_bytes(whole)
    saved_map.unlink()
    with pytest.raises(ValueError, match=r"map-\d+\.ot': is missing"):
        resume_survey(tmp_path)


def test_another_survey_into_the_same_folder_sets_the_unfinished_one_aside(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    saved_pool(tmp_path)
    run_survey("pool", tmp_path, mission_time_s=3.0)
    assert "an unfinished survey was in" in capfd.readouterr().err
    assert (tmp_path / "checkpoint.old" / "survey.state").exists()
    assert not (tmp_path / "checkpoint").exists()


def test_a_mission_that_saves_nothing_flies_but_cannot_be_resumed(tmp_path: Path) -> None:
    class Hover:
        progress = 0.0

        def __init__(self, vehicle: object, clock: object, plan: object) -> None:
            self.clock = clock

        def run(self) -> str:
            for _ in range(10):
                self.clock.wait(0.1)
            return "hovered"

    _, record = fly_survey(Simulator("pool"), mission=Hover, watch=SaveAt(Checkpoint(tmp_path), 5, 99))
    assert record.stopped_because == "hovered"
    saved = Checkpoint(tmp_path).read()
    with pytest.raises(ValueError, match="mission Hover: cannot be resumed: it has no save and restore"):
        fly_survey(Simulator("pool"), saved.occupancy, mission=Hover, resume=saved.state)


def test_a_folder_that_goes_away_is_told_once_and_the_flight_goes_on(tmp_path: Path) -> None:
    told: list[str] = []
    out = tmp_path / "out"
    out.mkdir()
    watch = Autosave(Checkpoint(out), ORDER, 1e-6, told.append)
    shares: list[float] = []

    def trouble(share: float) -> None:
        shares.append(share)
        if len(shares) == 20:
            shutil.rmtree(out)
            out.write_text("in the way")
        if len(shares) > 40 and told and out.is_file():
            out.unlink()
            out.mkdir()

    occupancy, record = fly_survey(Simulator("pool"), watch=watch, on_progress=trouble)
    assert record.stopped_because == "all lanes are flown"
    assert [text.split(":")[0] for text in told] == ["autosave failed", "autosave works again"]
    assert "flying on with the map in memory" in told[0]
    assert OccupancyMap.read(out / "map.bt").resolution_m == occupancy.resolution_m


def full_disk() -> None:
    """Files up to 100 bytes only, in this process."""
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))


def test_a_full_disk_in_flight_is_told_once_and_at_the_end_what_was_tried(tmp_path: Path) -> None:
    command = [*UWSIM, "survey", "pool", "--out", str(tmp_path), "--autosave", "0.001", "--mission-time", "60"]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False, preexec_fn=full_disk)
    assert result.returncode == 1
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 2, result.stderr
    assert "autosave failed" in lines[0]
    assert "flying on with the map in memory" in lines[0]
    assert "map.bt': cannot be written" in lines[1]
    assert "nor elsewhere" in lines[1]
    assert not [path for path in tmp_path.rglob("*") if path.is_file()], "nothing half-written"


def test_a_map_that_cannot_be_written_where_it_belongs_is_written_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    out = tmp_path / "out"
    write = OccupancyMap.write

    def full(self: OccupancyMap, path: Path) -> None:
        if out in Path(path).parents:
            raise OSError(f"'{path}': cannot be written: No space left on device")
        write(self, path)

    monkeypatch.setattr(OccupancyMap, "write", full)
    with pytest.raises(OSError, match=r"No space left on device; the map is in .*map\.bt") as raised:
        run_survey("pool", out, mission_time_s=3.0)
    saved = Path(str(raised.value).split("the map is in ")[1])
    assert len(OccupancyMap.read(saved).occupied_voxels()) > 0


@pytest.mark.parametrize("seconds", [-1.0, float("nan"), float("inf")])
def test_an_interval_that_is_none_is_refused(seconds: float, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"autosave_s = .*: must be 0"):
        run_survey("pool", tmp_path / "out", autosave_s=seconds)
    assert not any(tmp_path.iterdir())


def test_a_map_in_bounded_memory_is_the_same_also_when_resumed(tmp_path: Path) -> None:
    """At 0.05 m the pool's map takes more than the limit."""
    options = {"voxel_m": 0.05, "mission_time_s": 12.0}
    run_survey("pool", tmp_path / "whole", **options)
    out = tmp_path / "out"
    limited = ("pool", "--voxel", "0.05", "--mission-time", "12", "--map-memory", "2")
    process = start(out, *limited)
    wait_for(out / "checkpoint" / "survey.state", process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    resume_survey(out, map_memory_mb=2.0)
    assert (out / "map.bt").read_bytes() == (tmp_path / "whole" / "map.bt").read_bytes()


def test_a_verified_map_is_compared_byte_by_byte_also_when_resumed(tmp_path: Path) -> None:
    assert run_survey("pool", tmp_path / "a", mission_time_s=3.0, verify_map=True).verified is True
    assert run_survey("pool", tmp_path / "b", mission_time_s=3.0).verified is None
    out = tmp_path / "out"
    process = start(out, "pool", "--verify-map")
    wait_for(out / "checkpoint" / "survey.state", process)
    process.send_signal(signal.SIGKILL)
    process.communicate()
    assert list((out / "checkpoint").glob("reference-*.ot"))
    assert resume_survey(out).verified is True


def test_a_map_that_differs_from_stock_is_told_by_exit_code_1(tmp_path: Path) -> None:
    """A reference that misses one scan."""
    program = (
        "from uwsim.survey.checkpoint import SurveyOrder; from uwsim.mapping import OccupancyMap as M\n"
        "from uwsim.cli import main\n"
        "class Forgetful(M):\n"
        "    seen = 0\n"
        "    def insert_scan(self, *scan):\n"
        "        self.seen += 1\n"
        "        if self.seen != 20: super().insert_scan(*scan)\n"
        "SurveyOrder.new_reference = lambda order: Forgetful(resolution_m=order.voxel_m)\n"
        "main()"
    )
    command = [sys.executable, "-c", program, "survey", "pool", "--out", str(tmp_path), "--mission-time", "8"]
    result = subprocess.run([*command, "--verify-map"], capture_output=True, text=True, timeout=120, check=False)
    assert result.returncode == 1, result.stderr
    assert "map.bt DIFFERS from that of stock OctoMap" in result.stdout
    assert (tmp_path / "report.html").is_file()
