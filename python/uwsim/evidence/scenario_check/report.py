"""The report on a check: mistakes, warnings, and properties of the scene or vehicle."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

from uwsim.evidence.scenario_check.scene import Scene, plain
from uwsim.evidence.vehicle.figures import VehicleFigures
from uwsim.simulator.simulator import Simulator


@dataclass(frozen=True, eq=False)
class CheckReport:
    """The result of checking a file.

    mistakes, warnings: one line each. scene: None if the file has mistakes or is not a scenario. vehicle: properties in
    fresh water of the vehicle in a vehicle file, None for other files. simulator: a simulator of the scenario, or of
    the vehicle in open water.
    """

    file: str
    mistakes: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    scene: Scene | None = None
    simulator: Simulator | None = None
    vehicle: VehicleFigures | None = None

    def to_dict(self) -> dict[str, Any]:
        """Return the report as plain values, for JSON."""
        return {
            "file": self.file,
            "ok": not self.mistakes,
            "mistakes": list(self.mistakes),
            "warnings": list(self.warnings),
            "scene": None if self.scene is None else self.scene.to_dict(),
            "vehicle": None if self.vehicle is None else plain(asdict(self.vehicle)),
        }
