"""`uwsim ros doctor`: diagnoses why uwsim and other programs cannot see each other, and suggests remedies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["ok", "note", "wrong"]


@dataclass(frozen=True)
class Finding:
    """One line of the doctor's table: subject and observation. advice: the remedy, if the finding is not ok."""

    what: str
    found: str
    verdict: Verdict = "ok"
    advice: str = ""
