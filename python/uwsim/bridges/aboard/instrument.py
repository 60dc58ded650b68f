"""The instrument that a maker's protocol is for, by the name in an option."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from uwsim.simulator.simulator import Simulator
    from uwsim.simulator.vehicle import Vehicle


def instrument(
    switch: str, given: str, sim: Simulator, fitting: Callable[[Vehicle], list[str]], needed: str
) -> tuple[str, str]:
    """Return the vehicle's and the instrument's name. Raises ValueError.

    given: "NAME" of the first vehicle's, "VEHICLE/NAME", or "" for the first vehicle's first that fits. fitting:
    returns the names of a vehicle's instruments that fit. needed: which do, for the message.
    """
    vehicle, _, name = given.rpartition("/")
    vehicle = vehicle or sim.rov.name
    if vehicle not in sim.vehicles:
        raise ValueError(f"{switch}: vehicle '{vehicle[:40]}': must be one of {', '.join(sim.vehicles)}")
    names = fitting(sim.vehicles[vehicle])
    if not names:
        raise ValueError(f"{switch}: vehicle '{vehicle}' must have {needed}")
    if name and name not in names:
        raise ValueError(f"{switch}: instrument '{name[:40]}' of vehicle '{vehicle}': must be {' or '.join(names)}")
    return vehicle, name or names[0]
