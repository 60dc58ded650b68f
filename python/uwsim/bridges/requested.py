"""The bridges that a command's options request, of those that are registered in the socket `uwsim.bridges`."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from uwsim.base.options import Flag, FlagGroup, Options, RegisteredOptions, flag_name, require_named
from uwsim.base.sockets import blaming, load_all
from uwsim.bridges.plug import BridgePlug, Context

if TYPE_CHECKING:
    from uwsim.bridges.doctor import Finding
    from uwsim.simulator.simulator import Simulator

SOCKET = "uwsim.bridges"
"""The group of entry points of bridges: classes derived from BridgePlug."""


def offered() -> Mapping[str, type[BridgePlug[Any]]]:
    """Return the registered bridges by name. Warns with SocketWarning of other packages' that do not fit."""
    return load_all(SOCKET, _fitting)


def _fitting(name: str, found: Any) -> type[BridgePlug[Any]]:
    """Return a bridge's class. Raises TypeError or ValueError."""
    if not (isinstance(found, type) and issubclass(found, BridgePlug) and issubclass(found.options, Options)):
        raise TypeError(f"must be a class derived from {BridgePlug.__name__}, with options")
    require_named(SOCKET, name, found.options)
    return found


class Bridges(RegisteredOptions[Options]):
    """The options of all bridges that follow a live simulator. Raises OptionError.

    values: options by name. `prepare` comes before anything is built, then `check`, then `open`.
    """

    socket = SOCKET
    plays = False

    def __init__(self, **values: Any) -> None:
        super().__init__(**values)
        self._plugs: dict[str, BridgePlug[Any]] = {}

    @classmethod
    def offered(cls) -> Mapping[str, type[Options]]:
        """Return the classes of options by bridge."""
        return {name: plug.options for name, plug in offered().items() if not (cls.plays and plug.needs_live)}

    @property
    def names(self) -> list[str]:
        """The names of the requested bridges, which are their switches."""
        return list(self.requested)

    def prepare(self, given: Collection[str] = ()) -> None:
        """Check the bridges before anything is built. given: other options that were given, such as "ardusub".

        Raises ValueError or MissingExtraError.
        """
        for name, options in self.requested.items():
            plug = offered()[name]
            for other, why in plug.excluded_by.items():
                if other in given:
                    raise ValueError(f"{flag_name(name)}: cannot be given with {flag_name(other)}: {why}")
            self._plugs[name] = plug(options)

    def check(self, simulator: Simulator) -> None:
        """Raise ValueError for bridges that this simulator cannot serve."""
        for name, plug in self._plugs.items():
            if simulator.link is not None and not plug.crosses_link:
                rule = "does not cross the link; use a scenario without one, or --link none"
                raise ValueError(f"{flag_name(name)}: {rule}")

    def open(self, stack: ExitStack, context: Context) -> list[str]:
        """Open the bridges, which the stack closes; return their addresses, for the greeting.

        Raises OSError, ValueError or MissingExtraError.
        """
        for name, plug in self._plugs.items():
            with blaming(SOCKET, name, "open", (OSError, ValueError, ImportError)):
                context.opened[name] = stack.enter_context(plug.open(context))
        return [opened.address for opened in context.opened.values()]


class PlayedBridges(Bridges):
    """The options of all bridges to which a recording can be played."""

    plays = True


class ExaminedBridges(FlagGroup):
    """The options with which `uwsim ros doctor` examines all bridges. Raises OptionError."""

    def __init__(self, **values: Any) -> None:
        self._given = {
            name: plug.options(**{name: True} | {each: values[each] for each in plug.examined if each in values})
            for name, plug in offered().items()
            if plug.examined
        }

    @classmethod
    def flags(cls) -> Mapping[str, Flag]:
        """Return the flags that the examinations use."""
        return {name: plug.options.flags()[name] for plug in offered().values() for name in plug.examined}

    def examine(self, listen_s: float) -> Iterator[Finding]:
        """Yield what each bridge's examination finds. listen_s: how long to listen for peers [s]."""
        for name, options in self._given.items():
            yield from offered()[name].examine(options, listen_s)
