"""A hint for errors about unknown names: the known name with the most similar spelling, in whatever case."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Mapping

MIN_SIMILARITY = 0.6  # difflib's ratio: from 0 (nothing in common) to 1 (equal)


def did_you_mean(name: str, known: Iterable[str], written: Mapping[str, str] | None = None) -> str:
    """Return `; did you mean 'sonar'?` if a known name is similar, else "".

    written: how a name is written where it is not a plain name, such as {"imu": "sensors['imu']"}.
    """
    spelt = {each.lower(): each for each in known}
    near = difflib.get_close_matches(name.lower(), spelt, n=1, cutoff=MIN_SIMILARITY)
    if not near:
        return ""
    found = spelt[near[0]]
    return f"; did you mean {(written or {}).get(found, repr(found))}?"
