"""`--moos`: vehicles in MOOS communities, in place of their simulator."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, option
from uwsim.bridges.aboard.addressed import must_name_vehicles_once, steered_vehicles
from uwsim.bridges.doors.door import Door
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.bridges.aboard.aboard import Aboard
    from uwsim.bridges.doctor import Finding
    from uwsim.bridges.doors.endpoint import Endpoint


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
    moos_reports: bool = option(
        False, "MOOS: carry NODE_REPORT_LOCAL of each community to the others as NODE_REPORT, over the link's modems."
    )
    moos_shore: str | None = option(
        None, "MOOS: the shoreside's MOOSDB, for --moos-reports; its modem is the station's.", metavar="HOST:PORT"
    )


class MoosPlug(BridgePlug[MoosOptions]):
    """The vehicles in their communities. Raises ValueError for a wrong address."""

    options = MoosOptions
    needs_live = True
    excluded_by = {"ardusub": "the firmware steers"}  # noqa: RUF012  # read only
    examined = ("moos", "moos_name", "moos_shore")
    doors = (
        Door("`--moos`", "TCP", 0, "no address: it connects", "the MOOSDB at its target", "no program",
             ("--moos", "127.0.0.1:9")),
    )  # fmt: skip

    def __init__(self, options: MoosOptions) -> None:
        super().__init__(options)
        from uwsim.bridges.moos.client import FORM

        self._addresses = [FORM.parse(text) for text in options.moos]
        must_name_vehicles_once("moos", options.moos, self._addresses)
        if not options.moos_name.isidentifier():
            raise ValueError(f"moos_name = '{options.moos_name[:40]}': must have letters, digits and _ only")
        self._shore = None if options.moos_shore is None else FORM.parse(options.moos_shore)
        if self._shore is not None and (self._shore.owner or not options.moos_reports):
            rule = "must be HOST:PORT" if self._shore.owner else "needs --moos-reports"
            raise ValueError(f"moos_shore = '{options.moos_shore}': {rule}")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Join the communities; those that are not there yet are joined later. Raises ValueError."""
        from uwsim.bridges.moos.community import CommunityVehicle, Settings
        from uwsim.bridges.moos.reports import NodeReports
        from uwsim.channels import require_live
        from uwsim.scenario.georeference import georeference

        live, given = require_live(context.live), self.given
        if given.moos_reports and live.simulator.link is None:
            raise ValueError("moos_reports: needs a link, such as --link s2cm_hs, and the scenario has none")
        place = georeference(live.simulator.scenario)
        settings = Settings(
            given.moos_name, given.moos_rate, given.moos_control == "setpoints", given.moos_nav == "truth",
            given.moos_elevator,
        )  # fmt: skip

        reports = NodeReports(live) if given.moos_reports else None

        def vehicle(aboard: Aboard, address: Endpoint) -> CommunityVehicle:
            return CommunityVehicle(live, aboard, address, place, settings, reports)

        with steered_vehicles("moos", self._addresses, context, vehicle) as members, ExitStack() as shore:
            if reports is not None:
                if self._shore is not None:
                    shore.enter_context(reports.joined_shore(self._shore, given.moos_name))
                shore.enter_context(reports)
            where = ", ".join(f"{name} at {member.client.address}" for name, member in members.items())
            yield Opened(f"MOOS: {where}", members)

    @classmethod
    def examine(cls, options: MoosOptions, listen_s: float) -> Iterator[Finding]:
        """Join each MOOSDB for a moment, under a name of its own."""
        import time

        from uwsim.bridges.doctor import Finding
        from uwsim.bridges.moos.client import FORM, MoosClient

        for text in (*options.moos, *filter(None, [options.moos_shore])):
            address = FORM.parse(text)
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
