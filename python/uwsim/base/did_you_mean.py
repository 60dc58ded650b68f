"""A hint for errors about unknown names: the known name with the most similar spelling, in whatever case."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

MIN_SIMILARITY = 0.6  # difflib's ratio: from 0 (nothing in common) to 1 (equal)


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """Return `; did you mean 'sonar'?` if a known name is similar, else ""."""
    spelt = {each.lower(): each for each in known}
    near = difflib.get_close_matches(name.lower(), spelt, n=1, cutoff=MIN_SIMILARITY)
    return f"; did you mean '{spelt[near[0]]}'?" if near else ""
