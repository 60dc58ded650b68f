"""Seeds as text: a number of them, a list with ranges, or a file of such lists."""

from __future__ import annotations

from pathlib import Path

from uwsim.base.options import OptionError

MOST, MOST_LISTED = 100_000, 1000


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


def listed_seeds(text: str, option: str) -> list[int]:
    """Return the different seeds of a list with ranges, such as 1,2,5-20; a single number is a seed.

    option: its name, for messages. Raises OptionError.
    """
    found: list[int] = []
    for part in text.split(","):
        low, dash, high = part.strip().partition("-")
        if not (low.isdigit() and (high.isdigit() if dash else not high)) or len(low + high) > 12:
            raise OptionError(f"{option} {text}: '{part.strip()}': must be a whole number, or two as 5-20")
        found += range(int(low), int(high if dash else low) + 1)
        if not found or len(found) > MOST_LISTED:
            raise OptionError(f"{option} {text}: must be 1 to {MOST_LISTED} seeds, and a range's smaller number first")
    if len(set(found)) < len(found):
        raise OptionError(f"{option} {text}: must be different seeds")
    return found


def seeds_in(path: Path) -> list[int]:
    """Return the seeds of a file: lines as for listed_seeds; # begins a comment. Raises OptionError or OSError."""
    lines = [line.partition("#")[0].strip() for line in path.read_text(errors="replace").splitlines()]
    return listed_seeds(",".join(line for line in lines if line), f"--seeds {path}:")
