"""Reads the metadata of a recording without reading its messages, even if it was cut off."""

from __future__ import annotations

import struct
from contextlib import suppress
from pathlib import Path
from typing import IO, NamedTuple

from mcap.exceptions import EndOfFile
from mcap.opcode import Opcode
from mcap.reader import SeekingReader

from uwsim.base.texts.text_file import require_regular
from uwsim.recording.contents import parsed, places
from uwsim.recording.mcap_file import UNREADABLE
from uwsim.recording.mcap_sink import END, START, VERSION
from uwsim.recording.metadata import End, Start, checked

RECORD_BYTES_MAX = 1 << 24  # larger than any record that is read here
_CHUNK_TIMES = struct.Struct("<QQ")  # the first and last time in a chunk [ns]


class Glance(NamedTuple):
    """The metadata at the start, and at the end unless the recording was cut off. end_tick: the last whole tick."""

    start: Start
    end: End | None
    end_tick: int

    @property
    def duration_s(self) -> float:
        """The simulated time from the start to the end [s]; 0 if time was set back."""
        return max((self.end_tick - self.start.tick) * self.start.step_s, 0.0)


def glance(path: Path) -> Glance:
    """Return a recording's metadata. For a verification of the whole file, see Recording.

    Raises OSError, or ValueError if the file is not a recording, or has a different version.
    """
    last_ns, is_whole = None, True
    with require_regular(path).open("rb") as file:
        try:
            reader = SeekingReader(file, record_size_limit=RECORD_BYTES_MAX)
            metadata = {each.name: each.metadata for each in reader.iter_metadata()}
        except (*UNREADABLE, KeyError):
            is_whole = False
            metadata, last_ns = _of_cut_off(file)
    if START not in metadata or (is_whole and END not in metadata):
        raise ValueError(f"recording '{path}': was not written by uwsim" + (", or is still empty" * (not is_whole)))
    if (version := metadata[START].get("version", "none")) != VERSION:
        raise ValueError(f"recording '{path}': has version {version:.20}: this uwsim reads {VERSION}")
    try:
        start = checked(Start, metadata[START])
        end = checked(End, metadata[END]) if is_whole else None
    except ValueError as error:
        raise ValueError(f"recording '{path}': {error}") from None
    if end is not None:
        return Glance(start, end, end.tick)
    if last_ns is None:
        raise ValueError(f"recording '{path}': is cut off before its first message")
    return Glance(start, None, round(last_ns * 1e-9 / start.step_s))


def _of_cut_off(file: IO[bytes]) -> tuple[dict[str, dict[str, str]], int | None]:
    """Return the metadata at the start, and the last time in the last whole chunk [ns], or None without a chunk."""
    found, last_ns = dict[str, dict[str, str]](), None
    with suppress(EndOfFile, ValueError):
        for place in places(file):
            if place.kind == Opcode.METADATA and not found:
                metadata = parsed(place.kind, file.read(place.length))
                found[metadata.name] = metadata.metadata
            elif place.kind == Opcode.CHUNK and place.length >= _CHUNK_TIMES.size:
                _, last_ns = _CHUNK_TIMES.unpack(file.read(_CHUNK_TIMES.size))
    return found, last_ns
