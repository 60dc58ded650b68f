"""Descriptions in XML come from regular files: a device or a pipe may never end."""

import os
from pathlib import Path

import pytest

from uwsim.evidence.robots.xml_file import read_xml


def test_only_a_regular_file_is_read(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    for path in (Path("/dev/zero"), tmp_path / "pipe", tmp_path):
        with pytest.raises(ValueError, match="must be a regular file"):
            read_xml(path)
    with pytest.raises(FileNotFoundError):
        read_xml(tmp_path / "absent.sdf")
