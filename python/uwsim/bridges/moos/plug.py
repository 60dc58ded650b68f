"""`--moos`: vehicles in MOOS communities, in place of their simulator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, option
from uwsim.bridges.addressed import must_name_vehicles_once, steered_vehicles
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.bridges.actions import Action
    from uwsim.bridges.doctor.finding import Finding
    from uwsim.bridges.moos.client import Address


@dataclass(frozen=True)
class MoosOptions(Options):
    """The options of MOOS."""

    switch = "moos"

    moos: tuple[str, ...] = option(
        (),
        "Join the MOOSDB of a vehicle's community, at its time warp; repeat for others; see docs/connections/moos.md.",
        metavar="[VEHICLE=]HOST:PORT",
    )
    moos_name: str = option("uwsim", "MOOS: the application's name in its community.")
    moos_rate: float = option(10.0, "MOOS: NAV_* and sensors per simulated second.", bounds=(0.1, 100, "Hz"))
    moos_control: str = option(
        "actuators",
        "MOOS: obey DESIRED_THRUST, RUDDER and ELEVATOR, or the setpoints DESIRED_SPEED, HEADING and DEPTH.",
        choices=("actuators", "setpoints"),
    )
    moos_nav: str = option("estimate", "MOOS: what NAV_* is.", choices=("estimate", "truth"))
    moos_elevator: float = option(13.0, "MOOS: DESIRED_ELEVATOR at full effort.", bounds=(1, 100, "deg"))


class MoosPlug(BridgePlug[MoosOptions]):
    """The vehicles in their communities. Raises ValueError for a wrong address."""

    options = MoosOptions
    needs_live = True
    crosses_link = False
    excluded_by = {"ardusub": "the firmware steers"}  # noqa: RUF012  # read only
    examined = ("moos", "moos_name")

    def __init__(self, options: MoosOptions) -> None:
        super().__init__(options)
        from uwsim.bridges.moos.client import Address

        self._addresses = [Address.parse(text) for text in options.moos]
        must_name_vehicles_once("moos", options.moos, self._addresses)
        if not options.moos_name.isidentifier():
            raise ValueError(f"moos_name = '{options.moos_name[:40]}': must have letters, digits and _ only")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Join the communities; those that are not there yet are joined later. Raises ValueError."""
        from uwsim.bridges.moos.community import CommunityVehicle, Settings
        from uwsim.channels import require_live
        from uwsim.scenario.georeference import georeference

        live, given = require_live(context.live), self.given
        place = georeference(live.simulator.scenario)
        settings = Settings(
            given.moos_name, given.moos_rate, given.moos_control == "setpoints", given.moos_nav == "truth",
            given.moos_elevator,
        )  # fmt: skip

        def vehicle(action: Action, address: Address) -> CommunityVehicle:
            return CommunityVehicle(live, action, address, place, settings)

        with steered_vehicles("moos", self._addresses, context, vehicle) as members:
            where = ", ".join(f"{name} at {member.client.address}" for name, member in members.items())
            yield Opened(f"MOOS: {where}", members)

    @classmethod
    def examine(cls, options: MoosOptions, listen_s: float) -> Iterator[Finding]:
        """Join each MOOSDB for a moment, under a name of its own."""
        import time

        from uwsim.bridges.doctor.finding import Finding
        from uwsim.bridges.moos.client import Address, MoosClient

        for text in options.moos:
            address = Address.parse(text)
            met: list[str] = []

            def note(community: str, warp: float, met: list[str] = met) -> None:
                met.append(f"community '{community}', time warp {warp:g}")

            client = MoosClient(address, f"{options.moos_name}_doctor", (), lambda messages: None, note)
            with client:
                until_s = time.monotonic() + max(listen_s, 1.0)
                while not met and time.monotonic() < until_s:
                    time.sleep(0.02)
            what = f"MOOSDB at {address}"
            if met:
                yield Finding(what, met[0])
            else:
                yield Finding(
                    what, "no answer", "wrong", "start it, for example with pAntler, or give its host and port"
                )
