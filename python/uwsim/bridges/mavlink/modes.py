"""ArduSub's flight modes, each represented by a set of holds or by a flight."""

from __future__ import annotations

from collections.abc import Mapping

CUSTOM_MODE = 1  # MAV_MODE_FLAG
MANUAL, STABILIZE, ALT_HOLD, AUTO, GUIDED, SURFACE, POSHOLD, SURFTRAK = 19, 0, 2, 3, 4, 9, 16, 21
HOLDS_OF: Mapping[int, tuple[str, ...]] = {
    MANUAL: (),
    STABILIZE: ("heading",),
    ALT_HOLD: ("heading", "depth"),
    SURFTRAK: ("heading", "altitude"),
    POSHOLD: ("heading", "depth", "position"),
}
"""The holds of each mode that is flown with sticks; see docs/guides/holds.md."""
NAMES: Mapping[int, str] = {
    MANUAL: "MANUAL",
    STABILIZE: "STABILIZE",
    ALT_HOLD: "ALT_HOLD",
    AUTO: "AUTO",
    GUIDED: "GUIDED",
    SURFACE: "SURFACE",
    POSHOLD: "POSHOLD",
    SURFTRAK: "SURFTRAK",
}


def mode_of(holds: tuple[str, ...]) -> int:
    """Return the mode with the most holds, all of which are among the active ones; MANUAL if there are none."""
    active = set(holds)
    return max(HOLDS_OF, key=lambda mode: (set(HOLDS_OF[mode]) <= active) * (1 + len(HOLDS_OF[mode])))
