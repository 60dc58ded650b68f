"""Saves and restores the states of lamps and camera motors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from uwsim.base.named import require_names
from uwsim.instruments.cameras.lamp import Lamp
from uwsim.instruments.cameras.pan_tilt import Motion, PanTiltHead


class SavedLamps:
    """Saves which lamps are on, by vehicle and name."""

    STATE: ClassVar[Any] = dict[str, dict[str, bool]]

    def __init__(self, lamps: Mapping[str, Mapping[str, Lamp]]) -> None:
        self._lamps = lamps

    def save(self) -> dict[str, dict[str, bool]]:
        """Return the state as JSON values."""
        return {vehicle: {name: lamp.on for name, lamp in lamps.items()} for vehicle, lamps in self._lamps.items()}

    def restore(self, state: Mapping[str, Mapping[str, bool]]) -> None:
        """Continue from the result of `save`. Raises ValueError if the saved lamps differ from these."""
        require_names("lamps", _paths(state), _paths(self._lamps))
        for vehicle, lit in state.items():
            for name, on in lit.items():
                self._lamps[vehicle][name].set_silently(on)


class SavedHeads:
    """Saves the motion of cameras that have a motor, by name."""

    STATE: ClassVar[Any] = dict[str, Motion]

    def __init__(self, heads: Mapping[str, PanTiltHead]) -> None:
        self._heads = heads

    def save(self) -> dict[str, Any]:
        """Return the state as JSON values."""
        return {name: head.save() for name, head in self._heads.items()}

    def restore(self, state: Mapping[str, Motion]) -> None:
        """Continue from the result of `save`. Raises ValueError if the saved cameras differ from these."""
        require_names("cameras", state, self._heads)
        for name, motion in state.items():
            self._heads[name].restore(motion)


def _paths(lamps: Mapping[str, Mapping[str, object]]) -> list[str]:
    return [f"{vehicle}/{name}" for vehicle, named in lamps.items() for name in named]
