"""`--imc`: vehicles on our dynamics for DUNE and other systems that speak IMC."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import TYPE_CHECKING

from uwsim.base.options import Options, option
from uwsim.bridges.aboard.addressed import must_name_vehicles_once, steered_vehicles
from uwsim.bridges.doors.door import EVERYONE, IF_LOCAL, Door
from uwsim.bridges.plug import BridgePlug, Context, Opened

if TYPE_CHECKING:
    from uwsim.bridges.aboard.aboard import Aboard
    from uwsim.bridges.doctor import Finding
    from uwsim.bridges.doors.endpoint import Endpoint


@dataclass(frozen=True)
class ImcOptions(Options):
    """The options of IMC."""

    switch = "imc"

    imc: tuple[str, ...] = option(
        (),
        "Be the vehicle of a DUNE, by TCP or UDP, or announce it to consoles; repeat for others; see "
        "docs/connections/imc.md.",
        metavar="[VEHICLE=][udp:|announce:]HOST:PORT",
    )
    imc_sends: str = option(
        "truth",
        "IMC: the true motion, for DUNE's simulated instruments, or the vehicle's own instruments and estimate.",
        choices=("truth", "instruments"),
    )
    imc_rate: float = option(20.0, "IMC: publications per simulated second.", bounds=(0.1, 100, "Hz"))
    imc_id: int | None = option(None, "IMC: the vehicle's system number. Default: its peer's.", bounds=(0, 65534, ""))
    imc_rpm: float = option(2500.0, "IMC: revolutions at full command, for Rpm.", bounds=(1, 30000, "1/min"))
    imc_port: int = option(6001, "IMC: the port on which datagrams arrive.", bounds=(1, 65535, ""))


class ImcPlug(BridgePlug[ImcOptions]):
    """The vehicles with their systems. Raises ValueError for a wrong address."""

    options = ImcOptions
    needs_live = True
    excluded_by = {"ardusub": "the firmware steers"}  # noqa: RUF012  # read only
    examined = ("imc", "imc_port")
    doors = (
        Door("`--imc tcp`", "TCP", 0, "no address: it connects", "the system at its target", "no program",
             ("--imc", "tcp:127.0.0.1:9")),
        Door("`--imc udp`", "UDP", 1, IF_LOCAL, "IMC at port 6001 (`--imc-port`)",
             "the system at the target, which steers", ("--imc", "udp:127.0.0.1:9", "--imc-port", "{port}")),
        Door("`--imc announce`", "UDP", 1, "its own", "IMC at port 6001: consoles",
             f"{EVERYONE}: 16 that speak get what is published; it steers nothing",
             ("--imc", "announce:127.0.0.1:{port}", "--imc-id", "209")),
        Door("`--imc announce`", "UDP", 1, "127.0.0.1 if its own is, else all addresses",
             "announcements, at the first free port from 30100 to 30104", f"{EVERYONE}; a console is answered",
             ("--imc", "announce:127.0.0.1:{port}", "--imc-id", "209")),
    )  # fmt: skip

    def __init__(self, options: ImcOptions) -> None:
        super().__init__(options)
        from uwsim.bridges.imc.link import parsed

        self._addresses = [parsed(text) for text in options.imc]
        must_name_vehicles_once("imc", options.imc, self._addresses)
        if options.imc_id is None and any(each.kind == "announce" for each in self._addresses):
            raise ValueError(f"imc = {', '.join(options.imc)[:80]}: announce needs --imc-id, the vehicle's number")
        if sum(each.kind == "announce" for each in self._addresses) > 1:
            raise ValueError(f"imc = {', '.join(options.imc)[:80]}: must have announce once")
        if sum(each.kind == "udp" for each in self._addresses) > 1:
            raise ValueError(f"imc = {', '.join(options.imc)[:80]}: must have udp once; use tcp for further vehicles")

    @contextmanager
    def open(self, context: Context) -> Iterator[Opened]:
        """Connect; systems that are not there yet are met later. Raises ValueError, or MissingExtraError."""
        from uwsim.bridges.imc.readings import Place
        from uwsim.bridges.imc.vehicle import ImcVehicle, Settings
        from uwsim.channels import require_live
        from uwsim.scenario.georeference import georeference

        live, given = require_live(context.live), self.given
        if live.simulator.link is not None and any(each.kind == "announce" for each in self._addresses):
            raise ValueError("imc = announce: consoles are ashore, and the link's modems do not carry IMC")
        place = Place.of(georeference(live.simulator.scenario))
        settings = Settings(
            given.imc_rate, given.imc_sends == "instruments", given.imc_id, given.imc_rpm, given.imc_port
        )
        models = {entry.name: entry.model for entry in live.simulator.scenario.vehicles}

        def vehicle(aboard: Aboard, address: Endpoint) -> ImcVehicle:
            return ImcVehicle(live, aboard, models[aboard.source.name], address, place, settings)

        with steered_vehicles("imc", self._addresses, context, vehicle) as members:
            where = ", ".join(f"{name} at {member.link.address}" for name, member in members.items())
            yield Opened(f"IMC: {where}", members)

    @classmethod
    def examine(cls, options: ImcOptions, listen_s: float) -> Iterator[Finding]:
        """Listen to each system for a moment."""
        import time

        from uwsim.bridges.doctor import Finding
        from uwsim.bridges.imc.link import Identity, ImcLink, parsed
        from uwsim.bridges.imc.wire import Message

        for text in options.imc:
            address = parsed(text)
            if address.kind == "announce":
                yield Finding(f"IMC at {address}", "announced while uwsim serves")
                continue
            heard: list[Message] = []
            with ImcLink(address, Identity(None), heard.extend, listen_port=options.imc_port) as link:
                until_s = time.monotonic() + max(listen_s, 1.0)
                while not heard and time.monotonic() < until_s:
                    time.sleep(0.02)
                is_connected = link.is_connected and address.kind == "tcp"
            what = f"IMC at {address}"
            if heard:
                yield Finding(what, f"system 0x{heard[0].source:04X}")
            elif is_connected:
                fix = "let its Transports.TCP.Server transport Heartbeat, SetThrusterActuation and SetServoPosition"
                yield Finding(what, "a connection, but no message", "wrong", fix)
            else:
                yield Finding(what, "no answer", "wrong", "start DUNE with a Transports.TCP.Server, or give its port")
