"""Vehicles that systems aboard them steer, each at an address: what `--moos` and `--imc` share."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, Protocol, Self, TypeVar

from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.plug import Context

if TYPE_CHECKING:
    from uwsim.bridges.aboard.aboard import Aboard
    from uwsim.channels.delivery.feed import Reading


class Steered(AbstractContextManager[Any], Protocol):
    """A vehicle that a system steers while the context is open."""

    def __enter__(self) -> Self: ...

    def take_ping(self, reading: Reading) -> None:
        """Publish a ping of the sonar, a sensor_msgs/LaserScan. Does not block."""


SteeredT = TypeVar("SteeredT", bound=Steered)


def must_name_vehicles_once(switch: str, texts: Sequence[str], addresses: Sequence[Endpoint]) -> None:
    """Raise ValueError if two addresses are for one vehicle. texts: what was given."""
    vehicles = [each.owner for each in addresses]
    if len(set(vehicles)) < len(vehicles):
        raise ValueError(f"{switch} = {', '.join(texts)[:80]}: must name each vehicle once")


@contextmanager
def steered_vehicles(
    switch: str, addresses: Sequence[Endpoint], context: Context, make: Callable[[Aboard, Endpoint], SteeredT]
) -> Iterator[dict[str, SteeredT]]:
    """Open the vehicles of some addresses, and send them the pings of their sonars.

    Raises ValueError for a vehicle that is not there, that has no estimate, or that is named twice, and what `make`
    raises.
    """
    simulator = context.simulator
    with ExitStack() as opened:
        members: dict[str, SteeredT] = {}
        for address in addresses:
            name = address.owner or simulator.rov.name
            if name not in simulator.vehicles:
                raise ValueError(f"{switch}: vehicle '{name[:40]}': must be one of {', '.join(simulator.vehicles)}")
            if name not in context.aboard:
                raise ValueError(f"{switch}: vehicle '{name}' has no estimate to fly by: give it an IMU")
            if name in members:
                raise ValueError(f"{switch}: vehicle '{name}': must be named once")
            aboard = context.aboard[name]
            member = members[name] = opened.enter_context(make(aboard, address))
            if aboard.scan is not None:
                opened.callback(context.feed.listen(aboard.scan, member.take_ping))
        yield members
