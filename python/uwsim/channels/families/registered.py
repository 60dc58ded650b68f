"""Families of topics and services, which packages register by entry points; uwsim's own are registered, too."""

from __future__ import annotations

import inspect
import warnings
from collections.abc import Callable, Mapping, Set
from dataclasses import replace
from typing import Any

from uwsim.base.sockets import SocketWarning, blamed, blaming, load_all, registered
from uwsim.channels.channel import Channel, Delivery, Service
from uwsim.channels.names import SHARED, checked_namespace
from uwsim.channels.ros import build
from uwsim.channels.ros.message_types import resolve
from uwsim.channels.ros.service_types import SERVICE_TYPES
from uwsim.simulator.simulator import Simulator

GROUP = "uwsim.channels"
"""Functions that return a vehicle's topics and services. Their parameters are any of GIVEN, by name."""
GIVEN = frozenset({"source", "sim", "truth", "tf", "per_thruster", "pings", "maps", "pictures", "steering"})
"""`source`: the vehicle. `pings`: its multibeam's; what asks for them needs one. Others: see `Table`."""


def items_of(given: Mapping[str, Any], taken: set[str]) -> list[Channel | Service]:
    """Return all topics and services of a vehicle, uwsim's first. taken: the names of others.

    Warns with SocketWarning of another package's family that cannot be used, and goes on without it.
    """
    found: list[Channel | Service] = []
    for name, (family, asked) in load_all(GROUP, _family).items():
        if "pings" in asked and given["pings"] is None:
            continue
        entry, arguments = registered(GROUP)[name], {each: given[each] for each in asked}
        try:
            made = [one] if isinstance(one := family(**arguments), Channel) else one
            known = taken | SHARED | {each.name for each in found}
            found += made if entry.is_own else _checked(name, made, given["source"].prefix, known)
        except Exception as error:  # a stranger's function may raise anything
            if entry.is_own:
                raise
            warnings.warn(blamed(GROUP, entry, error), SocketWarning, stacklevel=2)
    return found


def _family(name: str, found: Any) -> tuple[Callable[..., Any], tuple[str, ...]]:
    """Return a function and the names of its parameters. Raises TypeError."""
    if not inspect.isfunction(found):
        raise TypeError(f"{type(found).__name__}: must be a function")
    asked = tuple(inspect.signature(found).parameters)
    if unknown := set(asked) - GIVEN:
        raise TypeError(f"parameter '{min(unknown)}': must be one of {', '.join(sorted(GIVEN))}")
    return found, asked


def _checked(entry: str, items: Any, prefix: str, taken: set[str]) -> list[Channel | Service]:
    """Return the items of another package, whose errors name its entry. Raises ValueError or TypeError."""
    found: list[Channel | Service] = []
    for item in items:
        if not isinstance(item, Channel | Service):
            raise TypeError(f"{type(item).__name__}: must be a Channel or a Service")
        if item.name in taken:
            raise ValueError(f"'{item.name}': the name is taken")
        if not item.name.startswith(prefix) or item.name != (checked_namespace(item.name) or None):
            raise ValueError(f"'{item.name}': must be a name of the vehicle's, see Source.topic")
        taken.add(item.name)
        if isinstance(item, Service):
            if item.type not in SERVICE_TYPES:
                raise ValueError(f"type = '{item.type}': must be one of {', '.join(SERVICE_TYPES)}")
            found.append(replace(item, call=_blaming(entry, item, "call")))
        elif resolve(item.type)[0] != item.type or not (1.0 if item.rate_hz is None else item.rate_hz) > 0.0:
            raise ValueError(f"'{item.name}': needs a type such as std_msgs/msg/String, and a positive rate or none")
        else:
            found.append(replace(item, read=_blaming(entry, item, "read"), apply=_blaming(entry, item, "apply")))
    return found


def _blaming(entry: str, item: Channel | Service, method: str) -> Callable[..., Any]:
    def called(*arguments: Any) -> Any:
        with blaming(GROUP, entry, f"{method} of {item.name}", (ValueError,)):
            found = getattr(item, method)(*arguments)
            if method == "read" and found is not None and getattr(found, "__msgtype__", None) != item.type:
                raise TypeError(f"{type(found).__name__}: must be a {item.type}")
            return found

    return called


TYPES = {float: "std_msgs/msg/Float64", bool: "std_msgs/msg/Bool", str: "std_msgs/msg/String"}


def logged_channels(sim: Simulator, taken: Set[str]) -> list[Channel]:
    """Return the topics of what has been logged so far. Raises ValueError for a name of another topic."""
    if both := sim.logged.values.keys() & taken:
        raise ValueError(f"log '/{min(both)}': the name is taken by a topic of the scenario")
    return [_channel(name, TYPES[type(value)]) for name, value in sim.logged.values.items()]


def _channel(name: str, kind: str) -> Channel:
    def follow(sim: Simulator, take: Any) -> Any:
        return sim.logged.listen(name, lambda value: take(build.message(kind, data=value)))

    read = lambda sim: build.message(kind, data=sim.logged.values[name])  # noqa: E731
    return Channel(name, kind, "out", "a value of the user's own", read=read, delivery=Delivery(True, follow=follow))
