"""A finding: what was looked at, what was found, whether it is wrong, and what to do."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

Verdict = Literal["ok", "note", "wrong"]


@dataclass(frozen=True)
class Finding:
    """One line of the table. advice: what to do, for what is not ok."""

    what: str
    found: str
    verdict: Verdict = "ok"
    advice: str = ""
