"""A survey on a failing disk: the flight continues, failures are reported once, and the map is saved elsewhere."""

from pathlib import Path

import pytest

from command_line import files_limited_to, uwsim_process
from uwsim.flight import results
from uwsim.flight.clock import FlightAutosave
from uwsim.flight.engine import Flight
from uwsim.flight.fly import fly
from uwsim.flight.record import DONE
from uwsim.flight.survey import run_survey
from uwsim.mapping import OccupancyMap


@pytest.fixture(autouse=True)
def no_files(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip all results except the map: they take longer than the flights and are tested elsewhere."""
    monkeypatch.setattr(results, "_write_files", lambda *arguments: None)
    monkeypatch.setattr(results, "scored", lambda flown, *arguments: flown)


def test_a_report_that_cannot_be_written_leaves_the_map(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(*arguments: object) -> None:
        raise OSError("No space left on device")

    monkeypatch.setattr(results, "_write_files", full)
    with pytest.raises(OSError, match=r"No space left.*map\.bt is complete"):
        run_survey("pool", tmp_path, mission_time_s=5.0, report="json")
    assert {path.name for path in tmp_path.iterdir()} == {"map.bt", "log.jsonl"}


def test_a_lost_folder_is_reported_once_and_the_flight_continues(
    small_pool: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    messages: list[str] = []
    out = tmp_path / "out"
    autosave = FlightAutosave(1e-6, messages.append)
    pauses, on_pause = [0], Flight._on_pause

    def lose_and_restore(flight: Flight, show: object) -> None:
        on_pause(flight, show)
        pauses[0] += 1
        if pauses[0] == 20:
            out.rename(tmp_path / "lost")  # done before anything else: an autosave thread may be writing in it
            out.write_text("in the way")
        if pauses[0] > 40 and messages and out.is_file():
            out.unlink()
            out.mkdir()

    monkeypatch.setattr(Flight, "_on_pause", lose_and_restore)
    flown = fly(None, small_pool, out, map=True, autosave=autosave)
    assert flown.ended_because == DONE
    assert [text.split(":")[0] for text in messages] == ["autosave failed", "autosave works again"]
    assert "the flight continues with the map in memory" in messages[0]
    assert OccupancyMap.read(out / "map.bt").resolution_m == flown.voxel_m


def test_a_full_disk_is_reported_with_all_attempts_at_the_end(tmp_path: Path) -> None:
    options = ("--autosave", "0.001", "--mission-time", "8", "--report", "none")
    result = uwsim_process("survey", "pool", "--out", str(tmp_path), *options, preexec_fn=files_limited_to(100))
    assert result.returncode == 1
    *in_flight, end = result.stderr.strip().splitlines()
    assert [line.split(" failed")[0] for line in in_flight] in ([], ["autosave"]), result.stderr
    assert "map.bt': cannot be written" in end
    assert "nor elsewhere" in end
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


def test_an_earlier_map_stays_until_the_new_flight_has_something_in_its_own(tmp_path: Path) -> None:
    run_survey("pool", tmp_path, mission_time_s=1.0, report="none")
    mapped = (tmp_path / "map.bt").read_bytes()
    with pytest.raises(ZeroDivisionError):
        fly(lambda rov: (yield 1 / 0), "pool", tmp_path, map=True, autosave_s=1e-3, report="none")  # type: ignore[arg-type]
    assert (tmp_path / "map.bt").read_bytes() == mapped
