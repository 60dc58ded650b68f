"""Documented modules that have moved. For one version, their old names still work, with a DeprecationWarning."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, cast

if TYPE_CHECKING:
    from importlib.abc import Loader  # importing it takes longer than everything else here

MOVED = {
    "uwsim.acoustics": "uwsim.instruments.acoustics",
    "uwsim.cameras": "uwsim.instruments.cameras",
    "uwsim.channels.build": "uwsim.channels.ros.build",
    "uwsim.channels.feed": "uwsim.channels.delivery.feed",
    "uwsim.channels.messages": "uwsim.channels.ros.messages",
    "uwsim.closure": "uwsim.mapping.closure",
    "uwsim.commands": "uwsim.base.commands",
    "uwsim.control": "uwsim.navigation.control",
    "uwsim.datasets": "uwsim.campaigns.datasets",
    "uwsim.estimation": "uwsim.navigation.estimation",
    "uwsim.failures": "uwsim.simulator.failures",
    "uwsim.fleet": "uwsim.campaigns.fleet",
    "uwsim.flight.exercise": "uwsim.exercises.flight",
    "uwsim.flight.remote": "uwsim.bridges.remote.flight",
    "uwsim.identification": "uwsim.evidence.identification",
    "uwsim.motion": "uwsim.base.motion",
    "uwsim.network": "uwsim.simulator.network",
    "uwsim.parameters": "uwsim.simulator.parameters",
    "uwsim.ranging": "uwsim.mapping.ranging",
    "uwsim.readings": "uwsim.instruments.readings",
    "uwsim.sample_stream": "uwsim.instruments.sample_stream",
    "uwsim.scenario_check": "uwsim.evidence.scenario_check",
    "uwsim.sensors": "uwsim.instruments.sensors",
    "uwsim.simulator.command_gate": "uwsim.simulator.helm",
    "uwsim.sonars": "uwsim.instruments.sonars",
    "uwsim.station": "uwsim.operator.station",
    "uwsim.sweeps": "uwsim.campaigns.sweeps",
    "uwsim.vehicle": "uwsim.simulator.vehicle",
    "uwsim.survey": "uwsim.flight",
    "uwsim.survey.run": "uwsim.flight.survey",
}
"""Old name: new name, for modules and for packages including their content."""


def new_name(old: str) -> str | None:
    """Return the new name for an old one, or None if the module has not moved."""
    if not old.startswith("uwsim."):
        return None
    parts = old.split(".")
    for end in range(len(parts), 1, -1):
        if (new := MOVED.get(".".join(parts[:end]))) is not None:
            return ".".join([new, *parts[end:]])
    return None


class _OldNames:
    """Finds a moved module under its old name, so that the module and its classes exist only once."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        new = new_name(fullname)
        if new is None:
            return None
        warnings.warn(f"{fullname} has moved: import {new}", DeprecationWarning, stacklevel=2)
        return ModuleSpec(fullname, cast("Loader", self))

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        module = import_module(str(new_name(spec.name)))
        spec.loader_state = module.__spec__
        return module

    def exec_module(self, module: ModuleType) -> None:
        """Restore the module's own spec, which the import has replaced; the module ran under its new name."""
        assert module.__spec__ is not None
        module.__spec__ = module.__spec__.loader_state


def lead_old_names_on() -> None:
    """Redirect imports of old names to the modules that have moved."""
    if not any(isinstance(finder, _OldNames) for finder in sys.meta_path):
        sys.meta_path.insert(0, _OldNames())
