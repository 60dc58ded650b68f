"""The record part of a score sheet: a person, a date, the build, and a digest by which a change is noticed.

The digest is no signature: anyone can change a sheet and compute another one. It shows mistakes, not fraud.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from uwsim.base.texts.json_text import read_json
from uwsim.exercises.course import Course
from uwsim.scenario.fingerprint import build_fingerprint

PERSON_MAX = 80
TEXTS = ("person", "title", "date")


def checked_person(name: str) -> str:
    """Return a person's name as it is given, without spaces at its ends. Raises ValueError."""
    found = name.strip()
    if not found or len(found) > PERSON_MAX or not found.isprintable():
        raise ValueError(f"person = {name[:PERSON_MAX]!r}: must have 1 to {PERSON_MAX} printable characters")
    return found


def certified_sheet(course: Course, person: str = "", script: str = "", recording: str = "") -> dict[str, Any]:
    """Return the sheet of a course with person, date, build and digest.

    script: the name of the mission that flew it, if it was no person. recording: the name of the run's recording from
    the begin, if there is one.
    """
    sheet = {
        **course.sheet(),
        "person": checked_person(person) if person else "",
        "script": script,
        "recording": recording,
        "date": datetime.now().astimezone().isoformat(timespec="seconds"),
        "uwsim": metadata.version("uwsim"),
        "build": build_fingerprint(),
    }
    return {**sheet, "digest": digest_of(sheet)}


def digest_of(sheet: Mapping[str, Any]) -> str:
    """Return the digest of all values but its own: 32 hexadecimal digits of BLAKE2b."""
    values = {key: value for key, value in sheet.items() if key != "digest"}
    text = json.dumps(values, sort_keys=True, separators=(",", ":"))
    return hashlib.blake2b(text.encode(), digest_size=16).hexdigest()


def read_sheet(path: Path) -> dict[str, Any]:
    """Return the sheet in a file score.json. Raises OSError, or ValueError if it has been changed."""
    sheet = read_json(path)
    if not isinstance(sheet, dict) or not isinstance(sheet.get("digest"), str):
        raise ValueError(f"'{path}': is not a score sheet with a digest")
    if digest_of(sheet) != sheet["digest"]:
        raise ValueError(f"'{path}': has been changed since it was written: its content does not have its digest")
    if not all(isinstance(sheet.get(name), str) for name in TEXTS):
        raise ValueError(f"'{path}': is not a score sheet with {', '.join(TEXTS)}")
    return sheet
