"""A bridge for the socket `uwsim.bridges`: a class with options, a check before anything is built, and `open`.

Its module is imported for `uwsim serve --help`, so it imports what it opens only when it opens it.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from uwsim.base.options import Options
from uwsim.bridges.doors.door import Door

if TYPE_CHECKING:
    from uwsim.bridges.aboard.aboard import Aboard
    from uwsim.bridges.actions import Action, Offered
    from uwsim.bridges.doctor import Finding
    from uwsim.channels import Channel, Service
    from uwsim.channels.delivery.feed import Readings
    from uwsim.live import LiveSimulator
    from uwsim.simulator.simulator import Simulator

OptionsT = TypeVar("OptionsT", bound=Options)


@dataclass(frozen=True)
class Opened:
    """An open bridge. address: where its peers find it, for the greeting. bridge: the object, for other bridges."""

    address: str
    bridge: Any = None


@dataclass(frozen=True)
class Context:
    """The simulator or recording that a bridge opens to its peers.

    channels, services, actions: as peers see them, with the namespace in their names. feed: the readings of the
    channels, taken once for all bridges. live: None for a recording that is played back, which accepts no commands and
    has neither services nor actions. origin: the world's origin in odom, as for a Table. namespace: part of the names
    of nodes. access: the arguments host, origins, token, certfile and keyfile that all servers share. opened: the
    bridges that were opened before, by name. aboard: the vehicles for systems aboard them, by name.
    """

    channels: Sequence[Channel]
    feed: Readings
    live: LiveSimulator | None = None
    services: Sequence[Service] = ()
    actions: Sequence[Offered] = ()
    origin: str = "world"
    namespace: str = ""
    access: Mapping[str, Any] = field(default_factory=dict)
    opened: dict[str, Opened] = field(default_factory=dict)
    aboard: Mapping[str, Aboard] = field(default_factory=dict)

    @property
    def simulator(self) -> Simulator:
        """The simulator. Raises NotRunningError for a recording."""
        from uwsim.channels import require_live

        return require_live(self.live).simulator

    @property
    def flights(self) -> dict[str, Action]:
        """The actions that fly a vehicle along a path, by the vehicle's name."""
        from uwsim.bridges.actions import Action

        return {
            each.source.name: each
            for each in self.actions
            if isinstance(each, Action) and each.name.endswith("fly_path")
        }


class BridgePlug(Generic[OptionsT]):
    """A bridge that `uwsim serve` and, if it can play recordings, `uwsim replay` offer by its options.

    The constructor checks what can be checked before anything is built. Raises ValueError or MissingExtraError.

    options: the class of its options, whose switch is the name under which the bridge is registered; the names of the
    others begin with it. needs_live: whether it refuses recordings. crosses_link: whether it carries what crosses the
    link between station and vehicle; otherwise it is refused if there is a link. excluded_by: reasons why it cannot be
    given with another option, by that option's name. examined: the options that `examine` uses. doors: the sockets on
    which it receives, for each kind of address; a plug whose options open none states that by a door that counts 0.
    """

    options: ClassVar[type[Options]]
    needs_live: ClassVar[bool] = False
    crosses_link: ClassVar[bool] = True
    excluded_by: ClassVar[Mapping[str, str]] = MappingProxyType({})
    examined: ClassVar[tuple[str, ...]] = ()
    doors: ClassVar[tuple[Door, ...]] = ()

    def __init__(self, options: OptionsT) -> None:
        self.given = options

    def open(self, context: Context) -> AbstractContextManager[Opened]:
        """Return the bridge, which is open within a `with` statement. Raises OSError, ValueError, MissingExtraError."""
        raise NotImplementedError

    @classmethod
    def examine(cls, options: Any, listen_s: float) -> Iterable[Finding]:
        """Yield what `uwsim ros doctor` finds about this bridge. listen_s: how long to listen for peers [s]."""
        return ()
