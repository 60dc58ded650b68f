"""A vehicle that announces itself to consoles such as Neptus, which then get what it publishes.

A system announces itself every ANNOUNCE_S by datagrams to the ports DISCOVERY_PORTS of a multicast group, of the local
network and of its own machine, with the addresses of its services; see LSTS's DUNE, etc/common/transports.ini. A
console that announces itself or sends a message to the service is answered at once.
"""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Iterable
from contextlib import suppress
from typing import Any

from uwsim.bridges.doors.conversation import first_of
from uwsim.bridges.doors.datagrams import Address, Datagrams
from uwsim.bridges.doors.dialler import QueueDialler
from uwsim.bridges.doors.endpoint import Endpoint
from uwsim.bridges.doors.places import Places
from uwsim.bridges.imc.link import HEARTBEAT_S, POLL_S, QUERY, REPORT, Identity, logger
from uwsim.bridges.imc.wire import NO_SYSTEM, UNKNOWN_ENTITY, ImcError, Message, Sent, decoded, encoded

GROUP, BROADCAST = "224.0.75.69", "255.255.255.255"
DISCOVERY_PORTS = (30100, 30101, 30102, 30103, 30104)
ANNOUNCE_S, LOST_S = 10.0, 30.0
"""Time between announcements, and without a message after which a console is lost."""
CONSOLES_MAX = 16
"""If there are more, the one that was silent longest goes."""
UNDERWATER_VEHICLE = 2


class Announcer(QueueDialler[Message]):
    """Announces a vehicle, and sends what is published to every console that is there.

    identity: with a system number of its own. where: returns latitude and longitude [rad]. Consoles only listen: what
    they send commands nothing, but their requests for our entities are answered.
    """

    is_connected = True

    def __init__(
        self, address: Endpoint, identity: Identity, name: str, where: Callable[[], tuple[float, float]]
    ) -> None:
        super().__init__(str(address), logger, "uwsim-imc")
        self.address, self.identity, self._name, self._where = address, identity, name, where
        self._consoles: dict[int, Address] = {}
        self._places: Places[int] = Places(self._consoles.pop, CONSOLES_MAX, LOST_S)
        if not self._is_local:
            logger.warning("IMC at %s, beyond this machine, in plain text", address)

    @property
    def consoles(self) -> list[int]:
        """The numbers of the systems that are there."""
        return list(self._consoles)

    def publish(self, sent: Iterable[Sent]) -> None:
        """Queue messages of entities, all of the present time. Does not block; may be called on any thread."""
        if self._consoles:
            self._queue(self._message(*each) for each in sent)

    def _message(self, label: str, name: str, content: dict[str, Any]) -> Message:
        return Message(name, content, self.identity.system, self.identity.entity(label), time.time())

    async def _connect(self) -> None:
        with Datagrams((self.address.host, self.address.port)) as service, self._discovery() as discovery:
            service.speak_from(self.address.host)
            await first_of(self._speak(service), self._listen(service, service), self._listen(discovery, service))

    @property
    def _is_local(self) -> bool:
        return self.address.host.startswith("127.")

    def _discovery(self) -> Datagrams:
        """Return the socket on which announcements arrive, on the first free port. Raises OSError."""
        for port in DISCOVERY_PORTS:
            with suppress(OSError):
                found = Datagrams((self.address.host if self._is_local else "", port))
                break
        else:
            raise OSError(f"ports {DISCOVERY_PORTS[0]} to {DISCOVERY_PORTS[-1]} are in use")
        if not self._is_local:
            found.join(GROUP, self.address.host)
        return found

    async def _speak(self, service: Datagrams) -> None:
        announced_s = beat_s = -ANNOUNCE_S
        while True:
            now_s = time.monotonic()
            if now_s - announced_s >= ANNOUNCE_S:
                announced_s = now_s
                self._announce(service, ("127.0.0.1",) if self._is_local else (GROUP, BROADCAST, "127.0.0.1"))
            if now_s - beat_s >= HEARTBEAT_S:
                beat_s = now_s
                self.publish([("uwsim", "Heartbeat", {})])
            self._places.sweep()
            packets = [encoded(each) for each in await self._taken(POLL_S)]
            for there in self._consoles.values():
                for packet in packets:
                    service.send(packet, there)

    def _announce(self, service: Datagrams, hosts: Iterable[str]) -> None:
        latitude, longitude = self._where()
        packet = encoded(self._message("uwsim", "Announce", {
            "sys_name": self._name, "sys_type": UNDERWATER_VEHICLE, "owner": NO_SYSTEM, "lat": latitude,
            "lon": longitude, "services": f"imc+udp://{self.address.host}:{self.address.port}/",
        }))  # fmt: skip
        for host in hosts:
            for port in DISCOVERY_PORTS:
                service.send(packet, (host, port))

    async def _listen(self, source: Datagrams, service: Datagrams) -> None:
        while True:
            data, there = await source.read()
            try:
                message = decoded(data)
            except ImcError as error:
                self._rare.warning(f"{self.address}: {error}")
                continue
            if message.source not in (self.identity.system, NO_SYSTEM):
                self._take(message, there, service)

    def _take(self, message: Message, there: Address, service: Datagrams) -> None:
        is_new = message.source not in self._consoles
        if message.name == "Announce":
            found = re.findall(r"imc\+udp://([\d.]+):(\d{1,5})/", message.content["services"])
            ports = {host: int(port) for host, port in found if 0 < int(port) < 65536}
            if there[0] not in ports:
                return  # the service of another machine, or none
            there = (there[0], ports[there[0]])
        elif not is_new:
            there = self._consoles[message.source]
        self._consoles[message.source] = there
        self._places.renew(message.source)
        if is_new:
            logger.info("console 0x%04X at %s:%d", message.source, *there)
            self._announce(service, [there[0]])
        if message.name == "EntityList" and message.content["op"] == QUERY:
            answer = self._message("uwsim", "EntityList", {"op": REPORT, "list": self.identity.list})
            self._queue([answer._replace(destination=message.source, to_entity=UNKNOWN_ENTITY)])
