"""The table of kinds of imaging sonars: those of the native core, and those that packages derive from them in Python.

All are registered in the entry point group `uwsim.kinds.imaging_sonar`; docs/inside/extend.md adds one. The reader of
scenarios, the sonars and the parameters look kinds up here.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Any

from uwsim import _core
from uwsim.base.sockets import load, load_all, registered
from uwsim.scenario.spec.sensor_figure import SensorFigure
from uwsim.scenario.spec.sensor_kind import Figure

GROUP = "uwsim.kinds.imaging_sonar"
FIGURE = "figure"
STRENGTHS = "strengths_db"
"""The only parameter that is a mapping, from surface names to backscatter strengths; the core uses labels instead of
names."""


def figure(default: float, low: float, high: float, unit: str = "", meaning: str = "") -> Any:
    """Return the dataclass field of a parameter that the core's kind does not have: a number in [low, high]."""
    return field(default=default, metadata={FIGURE: Figure(math.nan, low, high, unit, meaning)})


def own_figures(model: type[Any]) -> dict[str, Figure]:
    """Return the parameters of a model that the core's kind does not have."""
    return {each.name: each.metadata[FIGURE] for each in fields(model) if FIGURE in each.metadata}


def core_kind(model: type[Any]) -> str:
    """Return the kind of the core that computes a model's echoes: its own, or that of the model it is derived from.

    Raises ValueError for a model without one.
    """
    for base in model.__mro__:
        if (kind := base.__dict__.get("kind")) in _core.imaging_kinds():
            return str(kind)
    raise ValueError(f"{model.__name__}: must be derived from a model of {', '.join(_core.imaging_kinds())}")


@dataclass(frozen=True)
class ImagingKind:
    """A kind of imaging sonar.

    model: the class of its parameters, a dataclass whose defaults are those of a typical instrument. A kind of the core
    derives it from uwsim.instruments.sonars.imaging.Acoustics, another one from the model of such a kind, whose result
    it changes; its own parameters are fields made by `figure`. ping: called as ping(sim, world_from_sonar, model, name,
    *arguments); pings once from a vehicle at the current time and returns the kind's result.
    """

    model: type[Any]
    ping: Callable[..., Any]

    @property
    def name(self) -> str:
        """The kind."""
        return str(self.model.kind)

    @property
    def meaning(self) -> str:
        """A description."""
        if self.name == core_kind(self.model):
            return _core.imaging_kind(self.name).meaning
        return (inspect.getdoc(self.model) or "").partition("\n")[0].rstrip(".")

    @property
    def parameters(self) -> dict[str, SensorFigure]:
        """The keys of this kind, besides STRENGTHS."""
        return {**_core.imaging_kind(core_kind(self.model)).parameters, **own_figures(self.model)}


def imaging_kinds() -> list[str]:
    """Return the names of all kinds, uwsim's own first."""
    return list(registered(GROUP))


def usable_imaging_kinds() -> list[ImagingKind]:
    """Return all kinds, uwsim's own first. Warns with SocketWarning of those of broken packages."""
    return list(load_all(GROUP, _fitting).values())


@cache
def imaging_kind(name: str) -> ImagingKind:
    """Return a kind. Raises ValueError for an unknown name, or one whose package is broken."""
    found: ImagingKind = load(GROUP, name, _fitting)
    return found


def _fitting(name: str, kind: Any) -> ImagingKind:
    if not isinstance(kind, ImagingKind):
        raise TypeError(f"must be a {ImagingKind.__module__}.ImagingKind")
    if kind.name != name:
        raise TypeError(f"is named '{kind.name}'")
    for each in fields(kind.model):
        if each.name not in (*kind.parameters, STRENGTHS):
            raise TypeError(f"{kind.model.__name__}.{each.name}: must be made by {figure.__module__}.figure")
    return kind
