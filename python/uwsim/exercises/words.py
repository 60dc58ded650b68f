"""The words of the station's page, which a film of an exercise has in common with it."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path
from typing import Any

from uwsim.base.texts.json_text import read_json

STRINGS = Path(__file__).parents[1] / "operator/station/page/strings"
ENDED_BY_LIMIT = "a limit is broken: "


def languages() -> list[str]:
    """Return the languages that there are, such as "en"."""
    return sorted(path.stem for path in STRINGS.glob("*.json"))


class Words:
    """The texts of an exercise in one of the languages. Raises ValueError for another."""

    def __init__(self, language: str = "en") -> None:
        if language not in languages():
            raise ValueError(f"lang = '{language[:20]}': must be one of {', '.join(languages())}")
        self._table = _table(language)

    def score(self, score: float, points: float) -> str:
        """Return the score as the page shows it."""
        text: str = self._table["exercise"]["score(score, points)"]
        return text.format(score=f"{round(score, 1):g}", points=f"{points:g}")

    def limit(self, kind: str, title: str) -> str:
        """Return why a broken limit cost points. title: in English; its number is added, if it has one."""
        reason = self._table["exercise"]["reasons"].get(kind)
        return title if reason is None else f"{reason} ({title})" if re.search(r"\d", title) else reason

    def ended(self, because: str) -> str:
        """Return why an exercise ended; a reason that is not known stays as it is."""
        if because.startswith(ENDED_BY_LIMIT):
            text: str = self._table["said"]["limitBroken(title)"]
            return text.format(title=because.removeprefix(ENDED_BY_LIMIT))
        return str(self._table["said"]["texts"].get(because, because))

    @property
    def contact(self) -> str:
        """The name of a contact."""
        return str(self._table["events"]["names"]["collision"])

    @property
    def end(self) -> str:
        """The name of a recording's end."""
        return str(self._table["exercise"]["end"])


@cache
def _table(language: str) -> dict[str, Any]:
    found: dict[str, Any] = read_json(STRINGS / f"{language}.json")
    return found
