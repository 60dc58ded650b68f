"""Reads the metadata at both ends of a finished recording, without reading its messages."""

from __future__ import annotations

import struct
from pathlib import Path

from mcap.exceptions import McapError
from mcap.reader import SeekingReader

from uwsim.recording.mcap_sink import END, START, VERSION
from uwsim.recording.metadata import End, Start, checked

RECORD_BYTES_MAX = 1 << 24  # larger than any record that is read here
_UNREADABLE = (McapError, struct.error, RuntimeError, ValueError, KeyError, EOFError, OverflowError, MemoryError)


def glance(path: Path) -> tuple[Start, End]:
    """Return the metadata at the start and at the end. For a verification of the whole file, see Recording.

    Raises OSError, or ValueError if the file is not a recording, was cut off, or has a different version.
    """
    with path.open("rb") as file:
        try:
            reader = SeekingReader(file, record_size_limit=RECORD_BYTES_MAX)
            metadata = {each.name: each.metadata for each in reader.iter_metadata()}
        except _UNREADABLE:
            raise ValueError(f"recording '{path}': is cut off, or is no recording") from None
    if START not in metadata or END not in metadata:
        raise ValueError(f"recording '{path}': was not written by uwsim")
    if metadata[START].get("version", VERSION) != VERSION:
        raise ValueError(
            f"recording '{path}': has version {metadata[START]['version']:.20}: this uwsim reads {VERSION}"
        )
    try:
        return checked(Start, metadata[START]), checked(End, metadata[END])
    except ValueError as error:
        raise ValueError(f"recording '{path}': {error}") from None
