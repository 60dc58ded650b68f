"""InstrumentPlug: a bridge that puts a maker's device in the place of an instrument, at each address of an option."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar

from uwsim.base.extras import need_extra
from uwsim.base.options import Options
from uwsim.bridges.doors.endpoint import Endpoint, EndpointForm
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.live import LiveSimulator
    from uwsim.simulator.simulator import Simulator
    from uwsim.simulator.vehicle import Vehicle

OptionsT = TypeVar("OptionsT", bound=Options)


class InstrumentPlug(BridgePlug[OptionsT]):
    """The devices at the addresses that the option has. Raises ValueError for a wrong address.

    title: the device's name. needed: which instruments it can be, for messages. form: of its addresses, whose owner is
    an instrument. module: of the extra that it needs.
    """

    needs_live = True
    crosses_link = False
    title: ClassVar[str]
    needed: ClassVar[str]
    form: ClassVar[EndpointForm]
    module: ClassVar[str] = ""

    def __init__(self, options: OptionsT) -> None:
        super().__init__(options)
        self._switch = str(options.switch)
        texts = getattr(options, self._switch)
        if texts and self.module:
            need_extra(self.module, f"--{self._switch}")
        self._addresses = [self.form.parse(text) for text in texts]

    def fitting(self, vehicle: Vehicle) -> list[str]:
        """Return the names of a vehicle's instruments that it can be."""
        raise NotImplementedError

    def device(self, live: LiveSimulator, vehicle: str, name: str, address: Endpoint) -> AbstractContextManager[Any]:
        """Return the device, which has an `address`. Raises OSError."""
        raise NotImplementedError

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Answer until the `with` statement ends. Raises OSError, or ValueError for an instrument that does not fit."""
        from uwsim.channels import require_live

        live = require_live(context.live)
        with ExitStack() as stack:
            devices = []
            for address in self._addresses:
                vehicle, name = self._instrument(address.owner, live.simulator)
                devices.append(stack.enter_context(self.device(live, vehicle, name, address)))
            yield Opened(f"{self.title} at {', '.join(each.address for each in devices)}", devices)

    def _instrument(self, given: str, sim: Simulator) -> tuple[str, str]:
        """Return the vehicle's and the instrument's name. Raises ValueError.

        given: "NAME" of the first vehicle's, "VEHICLE/NAME", or "" for the first vehicle's first that fits.
        """
        vehicle, _, name = given.rpartition("/")
        vehicle, switch = vehicle or sim.rov.name, self._switch
        if vehicle not in sim.vehicles:
            raise ValueError(f"{switch}: vehicle '{vehicle[:40]}': must be one of {', '.join(sim.vehicles)}")
        names = self.fitting(sim.vehicles[vehicle])
        if not names:
            raise ValueError(f"{switch}: vehicle '{vehicle}' must have {self.needed}")
        if name and name not in names:
            raise ValueError(f"{switch}: instrument '{name[:40]}' of vehicle '{vehicle}': must be {' or '.join(names)}")
        return vehicle, name or names[0]
