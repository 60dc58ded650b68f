"""The geofence of a MAVLink vehicle: missions that leave it are refused, and breaches are reported."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from uwsim.bridges.mavlink.component import CRITICAL_TEXT, DONE, INFO_TEXT, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.settings import Settings
from uwsim.bridges.mavlink.state import State
from uwsim.bridges.mavlink.telemetry import EXTENDED_STATUS, Kind
from uwsim.missions.fence import Fence, zones_of

NO_BREACH, BOUNDARY = 0, 3  # FENCE_BREACH
NO_MITIGATION = 1  # FENCE_MITIGATE
STATUS_HZ = 1
FENCE_ENABLE, FENCE_ACTION = "FENCE_ENABLE", "FENCE_ACTION"


class FenceKeeper:
    """Keeps the fence that was uploaded, and compares missions and the vehicle's place with it. For one thread."""

    def __init__(self, craft: Craft, settings: Settings) -> None:
        self._craft, self._settings = craft, settings
        self._fence = Fence((), craft.home)
        self._seen: State | None = None
        self._is_breached, self._count, self._at_ms = False, 0, 0

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD: DO_FENCE_ENABLE."""
        return {207: self._on_enable}

    @property
    def kinds(self) -> list[Kind]:
        """The messages that are sent at a fixed rate: FENCE_STATUS, while there is a fence and it is enabled."""
        return [Kind(162, lambda mav, figures: self._status(mav), STATUS_HZ, EXTENDED_STATUS)]

    @property
    def _is_on(self) -> bool:
        return bool(self._settings[FENCE_ENABLE]) and bool(self._fence.zones)

    def _on_enable(self, given: Given) -> int:
        self._settings.set(FENCE_ENABLE, float(given.switch(1)))
        return DONE

    def keep(self, items: Iterable[Any]) -> int:
        """Replace the fence; return the number of its zones. Raises ValueError for items that do not fit together."""
        self._fence = Fence(zones_of(items), self._craft.home)
        self._is_breached = False
        return len(self._fence.zones)

    def refusal(self, items: Iterable[Any]) -> str | None:
        """Return which item of a mission, without that of home, leaves the fence; None if none does."""
        return self._fence.refusal(items) if self._is_on else None

    def watch(self, *, is_armed: bool) -> bool:
        """Report a breach and its end once each, while armed. Return whether FENCE_ACTION holds the vehicle now."""
        state = self._craft.state
        if state is None or state is self._seen:
            return False
        self._seen = state
        why = self._fence.breach(state.position_world_m) if self._is_on and is_armed else None
        was_breached, self._is_breached = self._is_breached, why is not None
        acts = self._is_on and self._settings[FENCE_ACTION] > 0
        self._craft.fence = bool(self._fence.zones), acts, why is None
        if was_breached and why is None:
            self._craft.send_text("Fence breach cleared", INFO_TEXT)
        if was_breached or why is None:
            return False
        self._count, self._at_ms = self._count + 1, round(1e3 * state.time_s) % 2**32
        x, y = (float(part) for part in state.position_world_m[:2])
        holds = self._settings[FENCE_ACTION] > 0
        what = "the vehicle is held" if holds else "reported only"
        self._craft.send_text(f"Fence breached: the vehicle at ({x:.1f}, {y:.1f}) m {why}: {what}", CRITICAL_TEXT)
        return holds

    def _status(self, mav: Any) -> Iterable[Any]:
        if not self._is_on:
            return []
        kind = BOUNDARY if self._is_breached else NO_BREACH
        values = int(self._is_breached), min(self._count, 0xFFFF), kind, self._at_ms, NO_MITIGATION
        return [mav.fence_status_encode(*values)]
