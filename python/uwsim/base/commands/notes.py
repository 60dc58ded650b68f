"""An operator's notes: an observation, and its position as estimated by the vehicle."""

from __future__ import annotations

from typing import Literal, get_args

COMMENT = "comment"
NoteCategory = Literal["observation", "defect", "leak", "debris", "growth"]
CATEGORIES = (*get_args(NoteCategory), COMMENT)
"""The categories of notes. The latest `comment` is shown in pictures; an empty comment removes it."""
TEXT_MAX = 200
PICTURE_MAX = 100
NOTES_MAX = 500
NOTE = "note"


def require_note(text: str, category: str, picture: str) -> None:
    """Raise ValueError if a note is too long, contains unprintable characters or has an unknown category."""
    for name, value, longest in (("text", text, TEXT_MAX), ("picture", picture, PICTURE_MAX)):
        if len(value) > longest or not all(char.isprintable() for char in value):
            raise ValueError(f"command 'note': {name} = {value[:40]!r}: must be at most {longest} printable characters")
    if category not in CATEGORIES:
        raise ValueError(f"command 'note': category = {category[:40]!r}: must be one of {', '.join(CATEGORIES)}")
