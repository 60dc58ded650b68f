"""Command: an entry in the table of commands. Argument: a parameter of a command, with unit and bounds."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import numpy as np

from uwsim.base.arguments import number
from uwsim.base.named import did_you_mean

Type = Literal["number", "numbers", "numbers by name", "flag", "text", "bytes", "any"]
REQUIRED: Final = object()
TRIGGER, SET_BOOL = "std_srvs/srv/Trigger", "std_srvs/srv/SetBool"


@dataclass(frozen=True)
class Argument:
    """A value that a command takes.

    low, high: inclusive bounds of each number. length: the number of values, for "numbers". default: used if the
    argument is missing; REQUIRED if the argument must be passed. An argument whose default is None may be None.
    """

    name: str
    type: Type = "number"
    unit: str = ""
    low: float = -math.inf
    high: float = math.inf
    length: int = 0
    default: Any = REQUIRED

    @property
    def is_required(self) -> bool:
        """Whether callers must pass the argument."""
        return self.default is REQUIRED

    def check(self, value: Any, path: str) -> None:
        """Raise ValueError if the value is not allowed. The message states the path, value, unit and rule."""
        if value is None and self.default is None:
            return
        if self.type == "number":
            self.check_number(value, path)
        elif self.type == "numbers":
            if not isinstance(value, Sequence | np.ndarray) or len(value) != self.length:
                raise ValueError(f"{path} = {value!r:.60}: must be {self.length} numbers{self._in_unit}")
            for k, item in enumerate(value):
                self.check_number(item, f"{path}[{k}]")
        elif self.type == "numbers by name":
            if not isinstance(value, Mapping):
                raise ValueError(f"{path} = {value!r:.60}: must be numbers by name{self._in_unit}")
            for name, item in value.items():
                self.check_number(item, f"{path}.{name}")
        elif self.type != "any" and not isinstance(value, CLASSES[self.type]):
            raise ValueError(f"{path} = {value!r:.60}: must be {WORDS[self.type]}")

    def check_number(self, value: Any, path: str) -> None:
        """Raise ValueError unless a value is a finite number within the bounds."""
        given, unit = number(value, path, self.unit), f" {self.unit}" if self.unit else ""
        if not math.isfinite(given):
            raise ValueError(f"{path} = {given}{unit}: must be finite")
        if not self.low <= given <= self.high:
            raise ValueError(f"{path} = {given}{unit}: must be in [{self.low:.6g}, {self.high:.6g}]{unit}")

    @property
    def _in_unit(self) -> str:
        return f" [{self.unit}]" if self.unit else ""


CLASSES: dict[str, Any] = {"flag": bool | np.bool_, "text": str, "bytes": bytes}
WORDS = {"flag": "True or False", "text": "text", "bytes": "bytes"}
VEHICLE, ANY_VEHICLE = Argument("vehicle", "text"), Argument("vehicle", "text", default=None)


@dataclass(frozen=True)
class Command:
    """A command that can be issued to a vehicle or the simulator.

    name: used in Python, in logs and recordings, and in every protocol. of: the kind of target, which is a vehicle, the
    simulator, or either of them (a vehicle if the argument `vehicle` is given). apply: applies the command; called with
    the target and the arguments as keywords; raises ValueError without changing anything. If it is None, the vehicle's
    method with the same name is called. notes_itself: whether `apply` reports to the simulator's journal, as methods
    do. takes_more: whether arguments that are not listed are passed on. crosses_link: whether the command travels over
    the link to its vehicle. replaces: whether it replaces an older command of the same name that is still waiting to be
    sent. is_vital: whether it is accepted even if the queue is full, and sent repeatedly to make sure that it arrives.
    steers: whether it drives the vehicle, and thus ends any earlier steering command. service: the ROS type of the
    vehicle's service with this name; "" for none. is_piloted: whether the station's pilot may issue it by name.
    is_ashore: whether it takes effect without reaching a vehicle, so that missions may issue it even if no link carries
    it. changes_world: whether it changes what a pilot must take as it is: the water, the light, faults, parameters, a
    vehicle's place.
    """

    name: str
    description: str
    arguments: tuple[Argument, ...] = ()
    apply: Callable[..., Any] | None = None
    of: Literal["vehicle", "simulator", "either"] = "vehicle"
    notes_itself: bool = False
    takes_more: bool = False
    crosses_link: bool = False
    replaces: bool = False
    is_vital: bool = False
    steers: bool = False
    service: str = ""
    is_piloted: bool = True
    is_ashore: bool = False
    changes_world: bool = False

    @property
    def all_arguments(self) -> tuple[Argument, ...]:
        """All arguments, including the vehicle's name, as they appear in logs."""
        vehicle = {"vehicle": (VEHICLE,), "simulator": (), "either": (ANY_VEHICLE,)}[self.of]
        return (*vehicle, *self.arguments)

    def argument(self, name: str) -> Argument:
        """Look up an argument by name."""
        return next(argument for argument in self.all_arguments if argument.name == name)

    def check(self, arguments: Mapping[str, Any]) -> None:
        """Raise ValueError unless these arguments are allowed."""
        known = {argument.name: argument for argument in self.all_arguments}
        for name in arguments:
            if name not in known and not self.takes_more:
                rule = f"must be one of {', '.join(known)}" if known else "it takes no arguments"
                raise ValueError(f"command '{self.name}': {name!r}: {rule}{did_you_mean(name, known)}")
        for name, argument in known.items():
            if name in arguments:
                argument.check(arguments[name], f"command '{self.name}': {name}")
            elif argument.is_required:
                raise ValueError(f"command '{self.name}': {name}: must be given")

    def bound(self, arguments: Mapping[str, Any]) -> Callable[[Any], Any]:
        """Return a function that applies the command, with these arguments, to a simulator. Raises ValueError."""
        self.check(arguments)

        def give(sim: Any) -> Any:
            vehicle = None if self.of == "simulator" else arguments.get("vehicle")
            return self.give(sim if vehicle is None else item(sim.vehicles, vehicle, "vehicle"), sim.journal, arguments)

        return give

    def named(self, vehicle: str, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Check the arguments, and return them with the vehicle's name added.

        Raises ValueError if they are invalid or the command targets the simulator.
        """
        if self.of == "simulator":
            raise ValueError(f"command '{self.name}': is for the simulator, not for vehicle '{vehicle}'")
        given = {"vehicle": vehicle, **arguments}
        self.check(given)
        return given

    def __call__(self, sim: Any, /, **arguments: Any) -> Any:
        """Apply the command to a simulator. Raises ValueError without changing anything."""
        return self.bound(arguments)(sim)

    def give(self, target: Any, journal: Any, arguments: Mapping[str, Any]) -> Any:
        """Apply the command to its target, with arguments that `check` accepted, and report it to the journal."""
        values = {name: value for name, value in arguments.items() if name != "vehicle" or self.of == "simulator"}
        if self.apply is None:
            return getattr(target, self.name)(**values)
        result = self.apply(target, **values)
        if not self.notes_itself:
            journal.note(self.name, **arguments)
        return result


def item(items: Mapping[str, Any], name: Any, what: str) -> Any:
    """Look up an item by name. Raises ValueError, listing the known names."""
    if not isinstance(name, str) or name not in items:
        raise ValueError(f"{what} = {name!r:.60}: must be one of {', '.join(items)}")
    return items[name]
