"""A survey on a failing disk: the flight goes on, failures are reported once, and the map is saved somewhere."""

from pathlib import Path

import pytest

from command_line import files_limited_to, uwsim_process
from uwsim import Simulator
from uwsim.mapping import OccupancyMap
from uwsim.survey.autosave import Autosave
from uwsim.survey.checkpoint import Checkpoint
from uwsim.survey.fly import fly_survey
from uwsim.survey.request import SurveyRequest
from uwsim.survey.run import resume_survey, run_survey

REQUEST = SurveyRequest("pool", 0, None, None, None, 0.5, "bricks", False)


@pytest.fixture(autouse=True)
def no_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the results: they take longer than the flights, and other tests cover them."""
    monkeypatch.setattr("uwsim.survey.run.write_results", lambda *arguments: None)


def test_resume_makes_a_report_that_could_not_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    reported: list[object] = []

    def full(*arguments: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr("uwsim.survey.run.write_results", full)
    with pytest.raises(OSError, match=r"No space left.*map\.bt is complete; uwsim survey --resume makes the report"):
        run_survey("pool", tmp_path, mission_time_s=5.0)
    flown = (tmp_path / "map.bt").read_bytes()
    write = lambda sim, occupancy, record, *more: reported.append(record)  # noqa: E731
    monkeypatch.setattr("uwsim.survey.run.write_results", write)
    record = resume_survey(tmp_path)
    assert [(each.ping_count, each.stopped_because) for each in reported] == [(50, record.stopped_because)]
    assert (tmp_path / "map.bt").read_bytes() == flown
    assert {path.name for path in tmp_path.iterdir()} == {"map.bt"}


def test_a_lost_folder_is_reported_once_and_the_flight_continues(tmp_path: Path) -> None:
    messages: list[str] = []
    out = tmp_path / "out"
    out.mkdir()
    autosave = Autosave(Checkpoint(out), REQUEST, 1e-6, messages.append)
    shares: list[float] = []

    def lose_and_restore(share: float) -> None:
        shares.append(share)
        if len(shares) == 20:
            out.rename(tmp_path / "lost")  # at once: an autosave on its own thread may be writing in it
            out.write_text("in the way")
        if len(shares) > 40 and messages and out.is_file():
            out.unlink()
            out.mkdir()

    occupancy, record = fly_survey(Simulator("pool"), supervisor=autosave, on_progress=lose_and_restore)
    assert record.stopped_because == "all lanes are flown"
    assert [text.split(":")[0] for text in messages] == ["autosave failed", "autosave works again"]
    assert "the flight continues with the map in memory" in messages[0]
    assert OccupancyMap.read(out / "map.bt").resolution_m == occupancy.resolution_m


def test_a_full_disk_is_reported_once_in_flight_and_with_all_attempts_at_the_end(tmp_path: Path) -> None:
    arguments = ("survey", "pool", "--out", str(tmp_path), "--autosave", "0.001", "--mission-time", "60")
    result = uwsim_process(*arguments, preexec_fn=files_limited_to(100))
    assert result.returncode == 1
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 2, result.stderr
    assert "autosave failed" in lines[0]
    assert "the flight continues with the map in memory" in lines[0]
    assert "map.bt': cannot be written" in lines[1]
    assert "nor elsewhere" in lines[1]
    assert not [path for path in tmp_path.rglob("*") if path.is_file()], "nothing half-written"


def test_a_map_that_cannot_be_written_in_its_folder_is_written_elsewhere(
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
