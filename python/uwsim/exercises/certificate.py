"""A pilot's certificate: what a person has flown, task by task, from the log book; a centre may sign it with its key.

The signature (`uwsim.base.signing`) states that the holder of the key has signed these values; the log book behind them
shows mistakes and no fraud (see `uwsim.exercises.logbook`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import datetime
from importlib import metadata
from pathlib import Path
from typing import Any

from uwsim.base.atomic_file import write_atomically
from uwsim.base.own_files import require_own
from uwsim.base.signing import SIGNATURE, signer_of
from uwsim.base.texts.json_text import read_json
from uwsim.exercises.certified import digest_of
from uwsim.exercises.exercise import exercise_names, load_exercise
from uwsim.exercises.logbook import Book, Entry, totals

TEMPLATE = Path(__file__).with_name("certificate.html.j2")
DATA, PAGE = "certificate.json", "certificate.html"
OTHER = "other exercises"
CONTENT = ("person", "date", "tasks", "totals", "logbook")


def certificate_of(book: Book, person: str, date: datetime | None = None) -> dict[str, Any]:
    """Return the certificate of a person, of values of JSON types, with the digest of all of them.

    Only lines of the log book that are as they were written count. tasks: of each kind of work, the exercises; of each
    exercise, the attempts, how many of them were valid, the best valid one and whether it has passed. The packaged
    exercises that were not flown are listed with no attempt. Raises ValueError for a person without a valid line.
    """
    own = [line.entry for line in book.lines if line.check == "valid" and line.entry.person == person]
    if not own:
        raise ValueError(f"person = '{person}': has no valid line in the log book")
    packaged = {each.title: each.task for each in map(load_exercise, exercise_names())}
    tasks: dict[str, dict[str, list[Entry]]] = {}
    for title, task in packaged.items():
        tasks.setdefault(task or OTHER, {})[title] = []
    for entry in own:
        task = entry.task or packaged.get(entry.title, "") or OTHER
        tasks.setdefault(task, {}).setdefault(entry.title, []).append(entry)
    values = {
        "person": person,
        "date": (date or datetime.now().astimezone()).isoformat(timespec="seconds"),
        "uwsim": metadata.version("uwsim"),
        "totals": totals(own)[person],
        "tasks": [
            {"task": task, "exercises": [_exercise(title, flown) for title, flown in exercises.items()]}
            for task, exercises in tasks.items()
        ],
        "logbook": {
            "lines": len(book.lines),
            "not_valid": sum(line.check != "valid" for line in book.lines),
            "sheets": [entry.digest for entry in own],
        },
    }
    return {**values, "digest": digest_of(values)}


def _exercise(title: str, flown: list[Entry]) -> dict[str, Any]:
    valid = [entry for entry in flown if entry.is_valid]
    best = max(valid, key=lambda entry: entry.score, default=None)
    return {
        "title": title,
        "attempts": len(flown),
        "valid": len(valid),
        "has_passed": any(entry.has_passed for entry in valid),
        "best": None if best is None else {"score": best.score, "points": best.points, "date": best.date},
    }


def write_certificate(out: Path, certificate: Mapping[str, Any]) -> list[Path]:
    """Write certificate.json and certificate.html into a folder; return their paths.

    Raises OSError, also if there is a file of one of these names that uwsim did not write.
    """
    from uwsim.figures.html_page import filled_page  # needs an extra

    for name in (DATA, PAGE):
        require_own(out / name)
    page = filled_page(TEMPLATE, sheet=certificate, tiles=_tiles(certificate))
    out.mkdir(parents=True, exist_ok=True)
    write_atomically(out / DATA, f"{json.dumps(certificate, indent=1)}\n".encode())
    write_atomically(out / PAGE, page.encode())
    return [out / DATA, out / PAGE]


def is_certificate(path: Path) -> bool:
    """Return whether a JSON file is a certificate and no score sheet. Raises OSError, or ValueError."""
    found = read_json(path)
    return isinstance(found, dict) and "tasks" in found


def check_certificate(path: Path, key: Path | None) -> str:
    """Return a line about who has signed a certificate. Raises OSError, or ValueError if it is not as it was signed.

    key: the centre's public key as PEM; without it, any valid signature is accepted and named.
    """
    found = read_json(path)
    if not isinstance(found, dict) or not all(name in found for name in CONTENT):
        raise ValueError(f"'{path}': is not a certificate with {', '.join(CONTENT)}")
    if digest_of({name: value for name, value in found.items() if name != SIGNATURE}) != found.get("digest"):
        raise ValueError(f"'{path}': has been changed since it was written: its content does not have its digest")
    who = f"{path}: is as it was written: {found['person']}, {found['date']}"
    if SIGNATURE not in found and key is None:
        return f"{who}; not signed"
    signer = signer_of(found, f"'{path}'", key)
    return f"{who}; signed by {signer if key is None else key}"


def _tiles(certificate: Mapping[str, Any]) -> tuple[tuple[str, str], ...]:
    total = certificate["totals"]
    return (
        (f"{total['passed']}", "exercises passed"),
        (f"{total['exercises']}", "exercises flown"),
        (f"{total['attempts']}", "attempts"),
        (f"{total['hours']:.1f} h" if total["hours"] >= 1.0 else f"{60 * total['hours']:.0f} min", "simulated"),
    )
