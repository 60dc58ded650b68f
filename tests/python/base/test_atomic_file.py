"""Atomic writes: a failure leaves the old file intact and no temporary file, and the error names the target."""

import errno
import os
import re

import pytest

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import mark


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
