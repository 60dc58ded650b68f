"""Reads the end of a recording file, whose index and counts must match the data."""

from __future__ import annotations

import zlib
from dataclasses import fields
from typing import Any

from mcap.opcode import Opcode
from mcap.records import Footer, Statistics

from uwsim.recording.contents import INDEXES, WRONG_CHECKSUM, Contents
from uwsim.recording.records import Record, RecordFile

WITHOUT_CHECKSUM = 16
"""Number of bytes of the footer's content that its checksum covers, in addition to the summary before it."""


def read_summary(file: RecordFile, contents: Contents) -> None:
    """Read everything after the data and verify it against the data. Raises CutOffError or ValueError."""
    start, file.checksum = file.position, 0
    given: dict[int, list[Any]] = {kind: [] for kind in INDEXES}
    statistics: Statistics | None = None
    while True:
        before, position = file.checksum, file.position
        record = file.record()
        with record.named(file):
            parsed = record.parsed()
            if isinstance(parsed, Footer):
                _compare_footer(record, parsed, start if position > start else 0, before, contents)
                break
            if record.kind in (Opcode.SCHEMA, Opcode.CHANNEL):
                contents.announce(parsed)
            elif record.kind in given:
                given[record.kind].append(parsed)
            elif isinstance(parsed, Statistics):
                _compare_counts(parsed, contents)
                statistics = parsed
            elif record.kind != Opcode.SUMMARY_OFFSET:
                raise ValueError("it is out of place")
    for kind, found in given.items():
        _compare_indexes(file, kind, found, contents)
    if contents.is_ours and statistics is None:
        raise file.damaged("the counts at its end are missing")
    if not file.magic():
        raise file.damaged("its last bytes are wrong")
    if not file.is_at_end:
        raise file.damaged(f"something follows its end at byte {file.position:,}")


def _compare_footer(record: Record, footer: Footer, start: int, before: int, contents: Contents) -> None:
    checksum = zlib.crc32(record.head + record.content[:WITHOUT_CHECKSUM], before)
    if footer.summary_crc != checksum and (footer.summary_crc or contents.is_ours):
        raise ValueError(f"the index, or the footer: {WRONG_CHECKSUM}")
    if footer.summary_start != start:
        raise ValueError("the index is not where the footer states")


def _compare_indexes(file: RecordFile, kind: int, given: list[Any], contents: Contents) -> None:
    """Raise ValueError if an index does not match the data. Other tools may omit indexes."""
    expected = contents.indexes[kind]
    what = INDEXES[kind]
    if not given and not contents.is_ours:
        return
    if len(given) != len(expected):
        raise file.damaged(f"{len(expected)} records of {what} are there, and {len(given)} in the index")
    for number, (one, other) in enumerate(zip(given, expected, strict=True), 1):
        if one != other:
            raise file.damaged(f"{what} {number} does not match the index")


def _compare_counts(given: Statistics, contents: Contents) -> None:
    """Raise ValueError if the counts do not match the data."""
    indexes = zip(contents.indexes[Opcode.CHUNK_INDEX], contents.chunks, strict=True)
    chunks = [index for index, chunk in indexes if chunk.channels]
    expected = Statistics(
        attachment_count=len(contents.attachments),
        channel_count=len(contents.channels),
        channel_message_counts=dict(contents.counts),
        chunk_count=len(contents.chunks),
        message_count=contents.counts.total(),
        message_end_time=max((chunk.message_end_time for chunk in chunks), default=0),
        message_start_time=min((chunk.message_start_time for chunk in chunks), default=0),
        metadata_count=len(contents.metadata),
        schema_count=len(contents.schemas),
    )
    for each in fields(Statistics):
        name, stated = each.name, getattr(given, each.name)
        if name == "channel_message_counts":
            stated = {channel: count for channel, count in stated.items() if count}
        if stated != getattr(expected, name):
            raise ValueError(f"its {name} is {stated}, but {getattr(expected, name)} is there")
