"""No command deletes or replaces a file that uwsim did not write, whatever its name: it is refused in one line."""

import os
import shutil
from pathlib import Path

import pytest

from command_line import uwsim
from flown import fly
from uwsim.base.own_files import is_own
from uwsim.flight.survey import run_survey
from uwsim.scenario.read import disk_cache

THEIRS = b"a summer of field work"
SURVEY = ("survey", "pool", "--mission-time", "1", "--report", "json", "--min-coverage", "0")
MISSION = "def mission(rov):\n    yield from rov.wait(0.5)\n"
SWEEP = "scenario: pool\nmission: m.py\nvary: {mission_time_s: {low: 2, high: 3, steps: 2}}\n"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "m.py").write_text(MISSION)
    (tmp_path / "out").mkdir()
    return tmp_path


def content(folder: Path) -> dict[str, bytes]:
    """Return the files of a folder; without Python's own caches, which it writes where a mission is imported."""
    files = [path for path in folder.rglob("*") if path.is_file() and path.parent.name != "__pycache__"]
    return {str(path.relative_to(folder)): path.read_bytes() for path in files}


def refused(folder: Path, *words: str) -> str:
    """Run a command that must change nothing, and return its only line."""
    before = content(folder)
    done = uwsim(*words, cwd=folder)
    assert done.returncode not in (0, None), done.stdout
    assert content(folder) == before
    lines = done.stderr.strip().splitlines()
    text = " ".join(lines)
    assert "uwsim did not write it" in text and "Traceback" not in text, done.stderr
    return text


@pytest.mark.parametrize(
    ("name", "words"),
    [
        *((name, (*SURVEY, "--out", "out")) for name in ("map.bt", "summary.json", "log.jsonl", "report.html")),
        ("track-rov.csv", ("run", "m.py", "--scenario", "pool", "--out", "out", "--report", "none")),
        ("report.html", ("sweep", "s.yaml", "--out", "out", "--workers", "0")),
        ("runs.parquet", ("sweep", "s.yaml", "--out", "out", "--workers", "0")),
        ("run.mcap", ("sweep", "s.yaml", "--again", "0", "--out", "out")),
        ("summary.json", ("fleet", "pool", "--tile", "20", "--out", "out", "--workers", "0")),
        ("compare.png", ("compare", "m.py", "--scenario", "pool", "--out", "out")),
        ("picture.png", ("scenario", "camera", "pool", "--out", "out/picture.png")),
        ("picture.png", ("scenario", "sonar", "pool", "--out", "out/picture.png")),
        ("map.ply", ("map", "convert", "own.bt", "out/map.ply")),
        ("map.bt", ("map", "convert", "own.ot", "out/map.bt")),
        ("new.yaml", ("scenario", "new", "new", "--out", "out/new.yaml")),
    ],
)
def test_a_foreign_file_where_a_command_writes_is_kept(folder: Path, name: str, words: tuple[str, ...], request):
    (folder / "s.yaml").write_text(SWEEP)
    if "convert" in words:
        world = run_survey("pool", folder / "survey", mission_time_s=1.0, report="none").occupancy
        world.write(folder / "own.bt"), world.write(folder / "own.ot")
    (folder / "out" / name).write_bytes(THEIRS)
    if words[:2] == ("scenario", "new"):  # which has an option to replace any file
        done = uwsim(*words, cwd=folder)
        assert done.returncode == 1 and "exists already; --force" in done.stderr
    else:
        refused(folder, *words)
    assert (folder / "out" / name).read_bytes() == THEIRS


@pytest.mark.parametrize(
    "words",
    [
        ("sweep", "s.yaml"), ("sweep", "s.yaml", "--resume"), ("fleet", "pool", "--tile", "20"),
        ("dataset", "pool", "--n", "1", "--size", "32x24"),
    ],
)  # fmt: skip
def test_a_foreign_ledger_without_a_last_newline_is_not_cut(folder: Path, words: tuple[str, ...]):
    (folder / "s.yaml").write_text(SWEEP)
    (folder / "out/ledger.jsonl").write_bytes(THEIRS)
    done = uwsim(*words, "--out", "out", "--workers", "0", cwd=folder)
    assert done.returncode == 1 and "is damaged" in done.stderr
    assert (folder / "out/ledger.jsonl").read_bytes() == THEIRS


def test_our_own_results_are_replaced_and_the_removed_ones_are_named(folder: Path):
    for expected in (0, 1):
        done = uwsim(*SURVEY, "--out", "out", cwd=folder)
        assert done.returncode == 0, done.stderr
        text = " ".join((done.stdout + done.stderr).split())
        assert text.count("removed the results of an earlier flight: map.bt, track.npz, summary.json") == expected
    (folder / "out/map.bt").write_bytes(THEIRS)  # over ours
    refused(folder, *SURVEY, "--out", "out")


def test_other_files_in_a_results_folder_stay(folder: Path):
    theirs = [
        "out/checkpoint/model.pt", "out/map-7.ot", "out/notes.txt",
        "out/.summary.json.keep", "out/.uwsim-1-2.tmp",
    ]  # fmt: skip
    for name in theirs:
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(THEIRS)
    assert uwsim(*SURVEY, "--autosave", "0.001", "--out", "out", cwd=folder).returncode == 0
    left = content(folder)
    assert {name: left.get(name) for name in theirs} == dict.fromkeys(theirs, THEIRS)


def test_a_folder_beside_a_sequence_and_dot_files_in_a_dataset_stay(folder: Path):
    (folder / "seq.unfinished").mkdir()
    (folder / "seq.unfinished/thesis.tex").write_bytes(THEIRS)
    done = uwsim("dataset", "pool", "--sequence", "m.py", "--out", "seq", cwd=folder)
    assert done.returncode == 1 and "uwsim did not make it" in " ".join(done.stderr.split())
    assert (folder / "seq.unfinished/thesis.tex").read_bytes() == THEIRS
    words = ("dataset", "pool", "--n", "1", "--size", "32x24", "--workers", "0", "--out", "data")
    done = uwsim(*words, cwd=folder)
    assert done.returncode == 0, done.stderr
    (folder / "data/images/.1-mine").write_bytes(THEIRS)
    assert uwsim(*words, "--resume", cwd=folder).returncode == 0
    assert (folder / "data/images/.1-mine").read_bytes() == THEIRS


def test_the_cache_evicts_only_what_it_wrote(tmp_path: Path, monkeypatch):
    monkeypatch.setenv("UWSIM_CACHE", str(tmp_path))
    for name in ("measured.npz", "measured.cached"):
        (tmp_path / name).write_bytes(1000 * THEIRS)
        os.utime(tmp_path / name, (0, 0))  # the oldest
    monkeypatch.setattr(disk_cache, "MAX_FOLDER_BYTES", 2000)
    monkeypatch.setattr(disk_cache, "CHECK_EVERY_BYTES", 0)
    for k in range(5):
        disk_cache.cached_json(lambda: "x" * 900, "test", str(k))
    own = [path for path in tmp_path.iterdir() if is_own(path)]
    assert 0 < len(own) < 5
    (newest,) = {path for path in own if path.stat().st_mtime == max(each.stat().st_mtime for each in own)}
    newest.write_bytes(3 * THEIRS)  # of our name, but not our content
    os.utime(newest, (0, 0))
    disk_cache.cached_json(lambda: "x" * 900, "test", "another")
    assert newest.read_bytes() == 3 * THEIRS
    assert all((tmp_path / name).read_bytes() == 1000 * THEIRS for name in ("measured.npz", "measured.cached"))


def test_a_recording_never_replaces_a_file(tmp_path: Path):
    path = fly(tmp_path / "run.mcap", end_s=0.5)
    shutil.copy(path, tmp_path / "copy.mcap")
    with pytest.raises(FileExistsError, match="exists already"):
        fly(path, end_s=0.5)
    assert path.read_bytes() == (tmp_path / "copy.mcap").read_bytes()
