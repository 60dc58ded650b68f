"""ArduSub's flight modes, and what they are here: sets of holds, and flights."""

from __future__ import annotations

from collections.abc import Mapping

MANUAL, STABILIZE, ALT_HOLD, AUTO, GUIDED, POSHOLD, SURFTRAK = 19, 0, 2, 3, 4, 16, 21
HOLDS_OF: Mapping[int, tuple[str, ...]] = {
    MANUAL: (),
    STABILIZE: ("heading",),
    ALT_HOLD: ("heading", "depth"),
    SURFTRAK: ("heading", "altitude"),
    POSHOLD: ("heading", "depth", "position"),
}
"""The holds of each mode that a stick flies; see docs/guides/holds.md."""
NAMES: Mapping[int, str] = {
    MANUAL: "MANUAL",
    STABILIZE: "STABILIZE",
    ALT_HOLD: "ALT_HOLD",
    AUTO: "AUTO",
    GUIDED: "GUIDED",
    POSHOLD: "POSHOLD",
    SURFTRAK: "SURFTRAK",
}


def mode_of(holds: tuple[str, ...]) -> int:
    """Return the mode with these holds, or the one that has most of them; MANUAL without any."""
    active = set(holds)
    return max(HOLDS_OF, key=lambda mode: (set(HOLDS_OF[mode]) <= active) * (1 + len(HOLDS_OF[mode])))
