"""Files of our own: written atomically or not at all, behind a lock, and nothing that others wrote is overwritten."""

import errno
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import uwsim
from command_line import error_line
from command_line import uwsim as command_line
from file_writes import LAWFUL, lawless_writers
from uwsim.base.atomic_file import write_atomically
from uwsim.base.folder_lock import LOCK, alone_in
from uwsim.base.own_files import LIST, is_own, mark, remove_own
from uwsim.mapping import OccupancyMap


@pytest.fixture(params=["attributes", "a file system without attributes"])
def marks(request, monkeypatch) -> None:
    """Where the marks are kept."""
    if request.param != "attributes":

        def refuse(*arguments, **options):
            raise OSError(errno.ENOTSUP, os.strerror(errno.ENOTSUP))

        monkeypatch.setattr(os, "setxattr", refuse)
        monkeypatch.setattr(os, "getxattr", refuse)


@pytest.mark.usefixtures("marks")
def test_our_own_file_is_replaced_and_any_other_is_not(tmp_path: Path):
    path = tmp_path / "summary.json"
    write_atomically(path, b"ours")
    write_atomically(path, b"ours again")
    assert path.read_bytes() == b"ours again" and is_own(path)
    theirs = tmp_path / "notes.json"
    theirs.write_bytes(b"theirs")
    refusal = rf"^'{re.escape(str(theirs))}': exists, and uwsim did not write it as it is: choose another name"
    with pytest.raises(OSError, match=refusal):
        write_atomically(theirs, b"ours")
    assert theirs.read_bytes() == b"theirs"
    write_atomically(theirs, b"asked for", replaces_any=True)
    assert theirs.read_bytes() == b"asked for"


@pytest.mark.usefixtures("marks")
def test_a_file_that_was_changed_or_put_over_ours_is_not_ours(tmp_path: Path):
    theirs = tmp_path / "real.bt"
    theirs.write_bytes(b"surveyed in the lake")
    for number, change in enumerate(
        (
            lambda path: shutil.copyfile(theirs, path),  # keeps the file, with its attributes
            lambda path: path.open("ab").write(b"a line"),
            lambda path: (path.unlink(), path.symlink_to(theirs)),
            lambda path: shutil.copy2(theirs, path),
        )
    ):
        path = tmp_path / f"map{number}.bt"
        write_atomically(path, b"ours")
        change(path)
        before = path.read_bytes()
        with pytest.raises(FileExistsError):
            write_atomically(path, b"ours")
        assert path.read_bytes() == before and theirs.read_bytes() == b"surveyed in the lake"


@pytest.mark.usefixtures("marks")
def test_a_map_replaces_only_a_map_of_ours(tmp_path: Path):
    world = OccupancyMap(resolution_m=0.5)
    world.insert_scan(np.array([[1.0, 2.0, -3.0]]), np.zeros(3))
    path = tmp_path / "map.bt"
    world.write(path)
    content = path.read_bytes()
    world.write(path)
    path.write_bytes(content[:-1])
    with pytest.raises(FileExistsError, match="uwsim did not write it as it is"):
        world.write(path)
    assert path.read_bytes() == content[:-1]
    assert {each.name for each in tmp_path.iterdir()} <= {"map.bt", LIST}


def test_who_writes_renames_or_removes_a_file_regards_those_of_others():
    """Each function that does, in the whole tree, by own_files, or for one of a few reasons."""
    here = Path(uwsim.__file__).parent
    lawful = [each for each in " ".join(LAWFUL.values()).split() if (here / each.partition(":")[0]).exists()]
    assert sorted(lawless_writers(here)) == sorted(lawful)  # add-ons may be deleted


@pytest.mark.usefixtures("marks")
def test_of_a_folder_only_our_files_are_removed(tmp_path: Path):
    folder = tmp_path / "checkpoint"
    (folder / "deep").mkdir(parents=True)
    for name in ("flight.json", "deep/map.ot"):
        write_atomically(folder / name, b"ours")
    (folder / "deep" / "model.pt").write_bytes(b"theirs")
    (folder / "link").symlink_to(tmp_path)
    assert sorted(remove_own(folder)) == [folder / "deep" / "model.pt", folder / "link"]
    assert (folder / "deep" / "model.pt").read_bytes() == b"theirs" and not (folder / "flight.json").exists()
    (folder / "deep" / "model.pt").unlink(), (folder / "link").unlink()
    assert remove_own(folder) == [] and not folder.exists()


def test_an_empty_file_loses_nothing_and_a_copy_is_not_ours(tmp_path: Path):
    path, copy = tmp_path / "made.png", tmp_path / "copy.png"
    path.touch()
    write_atomically(path, b"ours")
    copy.write_bytes(b"ours")
    assert is_own(path) and not is_own(copy)
    mark(tmp_path / "nowhere")  # is no error


def test_a_file_that_cannot_be_written_leaves_the_old_one_and_no_other(tmp_path):
    target = tmp_path / "report.html"
    target.mkdir()
    with pytest.raises(OSError, match=rf"^'{re.escape(str(target))}': cannot be written: Is a directory$"):
        write_atomically(target, b"new")
    assert list(tmp_path.iterdir()) == [target]
    nowhere = tmp_path / "nowhere" / "report.html"
    with pytest.raises(OSError, match=rf"^'{re.escape(str(nowhere))}': cannot be written: No such file or directory$"):
        write_atomically(nowhere, b"new")


@pytest.mark.parametrize("umask, mode", [(0o077, 0o600), (0o002, 0o664)])
def test_written_files_obey_the_umask(umask, mode, tmp_path):
    before = os.umask(umask)
    write_atomically(tmp_path / "a", b"")
    os.umask(before)
    assert (tmp_path / "a").stat().st_mode & 0o777 == mode


def test_an_error_on_a_full_disk_names_the_target(tmp_path, monkeypatch):
    def full(_descriptor):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    monkeypatch.setattr(os, "fsync", full)
    target = tmp_path / "report.html"
    target.write_bytes(b"old")
    mark(target)
    with pytest.raises(OSError, match=rf"^'{re.escape(str(target))}': cannot be written: No space left on device$"):
        write_atomically(target, b"new")
    assert list(tmp_path.iterdir()) == [target]
    assert target.read_bytes() == b"old"


HOLD = (
    "import sys, pathlib, time; from uwsim.base.folder_lock import alone_in\nwith alone_in(pathlib.Path(sys.argv[1])): "
)
SWEEP = "scenario: pool\nvary: {survey.altitude_m: {choices: [1.5]}}\n"


def test_a_second_run_into_one_folder_is_refused(tmp_path: Path) -> None:
    mission, sweep, out = tmp_path / "mission.py", tmp_path / "sweep.yaml", tmp_path / "out"
    mission.write_text("def mission(vehicle):\n    yield from ()\n")
    sweep.write_text(SWEEP)
    out.mkdir()
    for command in ("survey pool", f"run {mission} --scenario pool", f"sweep {sweep}", "fleet lake --tile 50"):
        with alone_in(out):
            message = error_line(command_line(*command.split(), "--out", str(out)))
            assert {path.name for path in out.iterdir()} == {LOCK}, "nothing is written"
        assert f"{out}" in message and "another run is using it (process " in message
        assert not list(out.iterdir())
    with alone_in(out):
        out.rename(tmp_path / "gone")  # is no error


def test_the_lock_of_a_killed_process_does_not_hinder(tmp_path: Path) -> None:
    words = [sys.executable, "-c", HOLD + "print('held', flush=True); time.sleep(1000)", str(tmp_path)]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None and holder.stdout.readline()
        with pytest.raises(OSError, match="another run is using it"), alone_in(tmp_path):
            pass
        holder.kill()
    assert (tmp_path / LOCK).exists()
    with alone_in(tmp_path):
        pass
    assert not (tmp_path / LOCK).exists()
