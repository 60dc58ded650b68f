"""Own files: nothing deletes or replaces a file that uwsim did not write, whatever its name."""

import errno
import os
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import uwsim
from file_writes import LAWFUL, lawless_writers
from uwsim.base.atomic_file import write_atomically
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
