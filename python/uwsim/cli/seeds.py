"""Seeds as text: a number of them, or a list with ranges."""

from __future__ import annotations

MOST = 100_000


def parsed_seeds(text: str, option: str) -> list[int]:
    """Return the seeds that a text means: 30 (0 to 29), 3,7 or 100-129; a single one is written 5-5.

    option: its name, for messages. Raises ValueError.
    """
    rule = f"{option} {text}: must be how many, such as 30, or a list, such as 0,1,2 or 100-129"
    seeds: list[int] = []
    try:
        if "," not in text and "-" not in text:
            text = f"0-{int(text) - 1}"
        for part in text.split(","):
            first, last = (int(end) for end in (part.split("-") if "-" in part else (part, part)))
            if not 0 <= first <= last < 2**32 or last - first >= MOST:
                raise ValueError
            seeds += range(first, last + 1)
    except ValueError:
        raise ValueError(rule) from None
    return seeds
