"""The map that a survey saves in flight: readable after a kill, and without effect on what is flown."""

import time
from pathlib import Path

import pytest

from command_line import start_survey, wait_for
from uwsim.base.atomic_file import write_atomically
from uwsim.flight.clock import FlightAutosave
from uwsim.flight.fly import fly
from uwsim.flight.record import FlightRecord
from uwsim.flight.survey import run_survey
from uwsim.mapping import OccupancyMap


@pytest.fixture(autouse=True)
def no_results(monkeypatch: pytest.MonkeyPatch) -> None:
    """Skip the results: they take longer than the flights and are tested elsewhere."""
    monkeypatch.setattr("uwsim.flight.engine.write_results", only_the_map)


def only_the_map(flown: FlightRecord, sim: object, out: Path, *arguments: object, **more: object) -> FlightRecord:
    flown.occupancy.write(out / "map.bt")
    return flown


class SaveOften(FlightAutosave):
    """Save a flight's map at every 20th pause."""

    pauses = 0

    def due(self) -> bool:
        self.pauses += 1
        return self.pauses % 20 == 0


def test_saving_does_not_change_the_map(small_pool: Path, surveyed: tuple[FlightRecord, Path], tmp_path: Path) -> None:
    saving = SaveOften(1e6)
    flown = fly(None, small_pool, tmp_path, map=True, map_growth=False, threads=2, autosave=saving)
    assert saving.pauses > 200 and "autosave" in flown.stage_wall_s
    assert flown.occupancy.to_bytes("ot") == surveyed[0].occupancy.to_bytes("ot")


def test_a_survey_that_is_killed_leaves_a_map_and_is_flown_again_to_the_same_bytes(
    small_pool: Path, surveyed: tuple[FlightRecord, Path], tmp_path: Path
) -> None:
    """At 0.1 m, so that a good part of the time is spent saving, when the process may be killed."""
    process = start_survey(tmp_path, str(small_pool), "--voxel", "0.1", "--report", "json")
    wait_for(tmp_path / "map.bt", process)
    time.sleep(0.23)
    process.kill()
    process.communicate()
    OccupancyMap.read(tmp_path / "map.bt")  # raises an error if the file is damaged
    assert (tmp_path / "log.jsonl").read_text().startswith('{"time_s":0.0,"vehicle":"","event":"begun"')
    run_survey(small_pool, tmp_path, threads=1)
    assert (tmp_path / "map.bt").read_bytes() == surveyed[0].occupancy.to_bytes("bt")
    assert not list(tmp_path.glob(".uwsim-*.tmp"))


def test_temporary_files_are_removed_even_if_the_process_was_killed_before_it_marked_them(tmp_path: Path) -> None:
    (tmp_path / ".uwsim-4194305-0.tmp").touch()  # larger than any process ID
    (tmp_path / ".track.npz.abc_1234").touch()
    (tmp_path / ".summary.json.abc_1234").write_bytes(b"foreign")
    run_survey("pool", tmp_path, mission_time_s=1.0)
    hidden = {path.name for path in tmp_path.iterdir() if path.name.startswith(".")}
    assert hidden == {".summary.json.abc_1234"}


def test_results_of_an_earlier_survey_are_removed(tmp_path: Path) -> None:
    earlier = [tmp_path / name for name in ("track.npz", "report.html", "map_from_above.png")]
    for path in earlier:
        write_atomically(path, b"of an earlier survey")
    run_survey("pool", tmp_path, mission_time_s=1.0)  # results are skipped, see no_results
    assert not any(path.exists() for path in earlier)


def test_an_invalid_autosave_interval_is_refused(tmp_path: Path) -> None:
    for seconds in (-1.0, float("nan"), float("inf")):
        with pytest.raises(ValueError, match=r"autosave_s = .*: must be 0"):
            run_survey("pool", tmp_path / "out", autosave_s=seconds)
    assert not any(tmp_path.iterdir())
