"""Carrier: sends the vehicles' messages over the link, and applies the station's messages when they arrive."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable
from concurrent.futures import Future
from dataclasses import replace
from functools import partial
from types import TracebackType
from typing import Any, Self

from uwsim.base.agenda import NEVER, Rank
from uwsim.base.commands import COMMANDS
from uwsim.base.named import did_you_mean
from uwsim.channels import Channel, Service, Table
from uwsim.channels.request import Request, following
from uwsim.link import remote
from uwsim.link.carried import Carried, carried_channels, is_chosen
from uwsim.link.offline import Offline
from uwsim.link.ranging import ranging_share
from uwsim.link.rates import send_rates
from uwsim.link.seen import seen_channels
from uwsim.link.turns import Turn, turns
from uwsim.live import LiveSimulator
from uwsim.simulator.network import STATION, Network
from uwsim.simulator.simulator import Simulator

COMMAND_LIFE_S = 5.0
"""The time for which a command may wait to be sent, or two rounds of all nodes if these take longer."""
VITAL_REPEATS = 2
"""The number of repetitions of an all stop, which is not acknowledged. Any one of the three copies suffices."""
LISTENED_S = 2.0
"""How long a channel counts as having a reader after it was last read."""
ONCE_HZ = 1.0
"""Rate of channels that specify none, over a cable or the ideal link."""

logger = logging.getLogger("uwsim.link")


class Carrier:
    """Operates both ends of a simulator's link.

        with LiveSimulator("lake", ...) as live, Carrier(live, table) as carrier:
            table.channels, table.services = carrier.channels, carrier.over(table.services)

    simulator: a live simulator, or a simulator that is stepped by its owner. table: the table of all its channels.
    Every message is sent by a logged command, so that a replay sends the same messages. Arriving messages are unpacked
    from the bytes that were carried. Over a modem, every channel named in the scenario is sent at a rate within the
    modem's capacity (`rates`); over a cable or the ideal link, only the channels that the station reads are sent. A
    picture is sent only after the previous one has been read. only: name endings of the channels that vehicles may
    send, unless the scenario selects them with `carries`.
    """

    def __init__(
        self, simulator: LiveSimulator | Simulator, table: Table, *, only: Iterable[str] | None = None
    ) -> None:
        live = Offline(simulator) if isinstance(simulator, Simulator) else simulator
        self._live: LiveSimulator = live  # type: ignore[assignment]  # Offline provides everything that is used here
        sim = live.simulator
        given = _chosen(table.channels, sim, only)
        network = sim.link
        if network is None or sim.scenario.link is None:
            raise ValueError("link: the scenario has none, or it is of kind 'none'")
        self._network: Network = network
        self._setup = sim.scenario.link
        self._carried = {one.channel.name: one for one in carried_channels(given, sim)}
        self._require_known(self._setup.repeats)
        self._listened: dict[str, int] = {}
        self.rates: dict[str, float] = {}
        self.channels = [
            self._sent_over(channel) if channel.direction == "in" else channel
            for channel in seen_channels(sim, table, given, self.note_read)
        ]
        self._sim = sim
        self._turns: list[Turn] = []
        self._arrived_ns = 0
        self._tick = -1  # the tick at which arrivals were last applied to the vehicles
        self._awaited_tick = NEVER

    def __repr__(self) -> str:
        return f"<Carrier of {len(self.channels)} channels over {self._setup.modem.kind}>"

    def _require_known(self, patterns: Iterable[str]) -> None:
        """Raise ValueError if a pattern matches no topic on the link."""
        topics = [*self._carried, *(remote.TOPIC + name for name in COMMANDS if remote.crosses_link(name))]
        for pattern in patterns:
            if not any(is_chosen(topic, (pattern,)) for topic in topics):
                hint = did_you_mean(pattern, topics)
                raise ValueError(f"link.repeats: '{pattern}': must match a channel that goes over the link{hint}")

    def start(self) -> Self:
        """Start carrying; return self.

        Raises NotRunningError if the live simulator is not running.
        """
        self._live.read(self._begin).result()
        return self

    def close(self) -> None:
        """Stop carrying messages."""
        for item in (self, *self._turns):
            self._sim.agenda.remove(item)

    def __enter__(self) -> Self:
        return self.start()

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Stop carrying messages."""
        self.close()

    def over(self, services: Iterable[Service]) -> list[Service]:
        """Return variants of the services that send their commands over the link and respond once these are queued."""
        return [replace(service, call=self._called(service)) for service in services]

    def _called(self, service: Service) -> Callable[[LiveSimulator, Request], Request | Future[Request]]:
        def call(live: LiveSimulator, request: Request) -> Request | Future[Request]:
            far = remote.RemoteSimulator(self._live, self.command)
            answer = service.call(far, request)  # type: ignore[arg-type]
            if isinstance(answer, Future):
                return following(answer, lambda: self._sent(far, answer.result()))
            return self._sent(far, answer)

        return call

    def _sent(self, far: remote.RemoteSimulator, answer: Request) -> Request:
        is_sent = far.has_sent and answer.get("success") and not answer.get("message")
        return {**answer, "message": f"sent over {self.modem}"} if is_sent else answer

    def remote(self) -> LiveSimulator:
        """Return the simulator as seen from the station: commands to vehicles go over the link."""
        return remote.RemoteSimulator(self._live, self.command)  # type: ignore[return-value]

    @property
    def modem(self) -> str:
        """The name of the modem."""
        return self._network.modem.name

    def newest(self, name: str, after_s: float = 0.0) -> Any:
        """Return the newest message on a vehicle's channel that has arrived since a simulated time, or None."""
        one = self._carried.get(name)
        found = [got for got in self._network.received(STATION, after_s) if got.topic == name]
        return one.packing.unpack(found[-1].payload, one.channel) if one is not None and found else None

    def command(self, name: str, vehicle: str, arguments: dict[str, Any]) -> Future[Any]:
        """Send one of uwsim.base.commands to a vehicle; the future resolves when it is queued."""
        topic, payload = remote.packed(name, arguments)
        stops = arguments.get("on", True) if COMMANDS[name].is_vital else None
        return self._send(vehicle, topic, payload, replaces=COMMANDS[name].replaces, stops=stops)

    def _sent_over(self, channel: Channel) -> Channel:
        one = self._carried.get(channel.name)
        if one is None:
            return channel

        def apply(live: LiveSimulator, message: Any) -> object:
            if remote.is_on_deck(self._sim, one.vehicle):
                return channel.apply(self._live, message)
            payload = one.packing.pack(message)
            return self._send(one.vehicle, channel.name, payload, replaces=one.packing.may_replace(message))

        abandoned, idle, far = channel.authority.abandoned, channel.authority.idle, self.remote()
        if abandoned is None:
            return replace(channel, apply=apply)
        # Aboard, silence may be due to the modem, so the station monitors the publishers and reports when they have
        # left.
        gone = (lambda live: abandoned(far)) if idle is None else (lambda live: apply(live, idle))
        return replace(channel, apply=apply, authority=replace(channel.authority, abandoned=gone))

    def _send(
        self, vehicle: str, topic: str, payload: bytes, *, replaces: bool, stops: bool | None = None
    ) -> Future[Any]:
        """Submit a message to the link.

        stops: True if it sets all stop, which is sent even if it is late, and repeated; False if it releases all stop,
        which may be lost; None for others.
        """
        repeats = max(self._repeats(topic), VITAL_REPEATS if stops else 0)
        issue = self._live.command if stops is None else partial(self._live.carry_stop, vehicle, stops)
        return issue(
            "link_send", sender=STATION, receiver=vehicle, topic=topic, payload=payload, priority=0,
            lifetime_s=None if stops else self._command_life_s(), replaces=replaces, repeats=repeats,
        )  # fmt: skip

    def _repeats(self, topic: str) -> int:
        """Return the number of times that messages on a topic are repeated."""
        patterns = self._setup.repeats.items()
        return max((times for pattern, times in patterns if is_chosen(topic, (pattern,))), default=0)

    def _command_life_s(self) -> float:
        modem = self._network.modem
        turn_s = (modem.slot_s + modem.guard_s) * len(self._network.nodes)
        return max(COMMAND_LIFE_S, 2.0 * turn_s) if modem.kind == "modem" else COMMAND_LIFE_S

    def note_read(self, name: str, sim: Simulator) -> None:
        """Record that the station reads a channel. Called on the simulator's thread."""
        self._listened[name] = sim.time_ns + round(1e9 * LISTENED_S)

    def _begin(self, sim: Simulator) -> None:
        self._arrived_ns = sim.time_ns
        self.rates = self._made_rates(sim)
        left_out = [
            name for name, one in self._carried.items() if name not in self.rates and one.channel.direction == "out"
        ]
        if left_out:
            logger.warning("the link has no room for %s", ", ".join(left_out))
        is_modem = self._network.modem.kind == "modem"
        self._turns = turns(self._carried, self.rates, sim.step_s, self._send_newest, shared=is_modem)
        for turn in self._turns:
            turn.due_tick = sim.tick
        sim.agenda.add(self, Rank.DELIVERY, self.act, jump=self.jump)
        for turn in self._turns:
            sim.agenda.add(turn, Rank.DELIVERY, turn.act, jump=turn.jump)

    def _made_rates(self, sim: Simulator) -> dict[str, float]:
        outgoing = [one for one in self._carried.values() if one.channel.direction == "out"]
        modem = self._network.modem
        if modem.kind != "modem":
            return {one.channel.name: one.channel.rate_hz or ONCE_HZ for one in outgoing}
        access, nodes = self._setup.access or modem.access, len(self._network.nodes)
        sizes = {one.channel.name: _size(one, sim) for one in outgoing}
        times = {one.channel.name: 1 + self._repeats(one.channel.name) for one in outgoing}
        rates: dict[str, float] = {}
        for vehicle in sim.vehicles:
            own = [one for one in outgoing if one.vehicle == vehicle]
            taken = ranging_share(sim, vehicle, modem, access, nodes)
            rates |= send_rates(own, sizes, modem, access, nodes, times=times, taken=taken)
        return rates

    @property
    def due_tick(self) -> int:
        """The first tick at which a message may arrive.

        Messages that have arrived but have not been applied are included, unlike in the network's next arrival.
        """
        arrival = -(-self._network.next_arrival_ns // round(self._sim.step_s * 1e9))
        self._awaited_tick = min(self._awaited_tick, arrival)
        return max(self._awaited_tick, self._tick + 1)

    def act(self, tick: int) -> None:
        """Apply arrived messages to the vehicles. Called on the simulator's thread, between two steps."""
        self._tick, self._awaited_tick = tick, NEVER
        for vehicle in self._sim.vehicles:
            self._receive(vehicle)
        self._arrived_ns = max(self._arrived_ns, self._sim.time_ns)

    def jump(self, tick: int) -> None:
        """Ignore earlier arrivals; called when simulated time has jumped."""
        self._tick, self._awaited_tick, self._arrived_ns = tick - 1, NEVER, self._sim.time_ns
        self._listened.clear()

    def _send_newest(self, name: str) -> bool:
        """Send a channel's current message; return whether there was one to send."""
        one, sim = self._carried[name], self._sim
        channel = one.channel
        only_if_read = self._network.modem.kind != "modem" or channel.delivery.late
        if only_if_read and self._listened.get(channel.name, -1) < sim.time_ns:
            return False
        try:
            message = channel.read(sim)
            payload = None if message is None else one.packing.pack(message)
        except Exception:
            logger.exception("channel '%s' cannot be sent", channel.name)
            return False
        if payload is not None:
            self._live.command(
                "link_send", sender=one.vehicle, receiver=STATION, topic=channel.name, payload=payload,
                priority=one.priority, replaces=True, lifetime_s=max(2.0 / self.rates[channel.name], 1.0),
                repeats=self._repeats(channel.name),
            )  # fmt: skip
            if channel.delivery.late:
                self._listened.pop(channel.name, None)  # the next picture is sent when this one has been read
        return payload is not None

    def _receive(self, vehicle: str) -> None:
        for got in self._network.received(vehicle, 1e-9 * self._arrived_ns):
            one = self._carried.get(got.topic)
            try:
                if one is not None:
                    one.channel.apply(self._live, one.packing.unpack(got.payload, one.channel))
                elif got.topic.startswith(remote.TOPIC):
                    name, arguments = remote.unpacked(got.topic, got.payload)
                    self._live.command(name, vehicle=vehicle, **arguments).add_done_callback(_log_error)
            except ValueError as error:
                logger.warning("'%s' refuses what has arrived: %s", vehicle, error)


def _chosen(channels: Iterable[Channel], sim: Simulator, only: Iterable[str] | None) -> list[Channel]:
    """Return the channels that do not cross the link, and those of the others whose names `only` selects."""
    setup, ends = sim.scenario.link, None if only is None else tuple(only)
    if ends is None or setup is None or "carries" in setup.model_fields_set:
        return list(channels)
    return [one for one in channels if one.direction == "in" or not one.over_link or one.name.endswith(ends)]


def _size(one: Carried, sim: Simulator) -> int:
    """Return the packed size [bytes] of a channel's messages: the usual size or, if unknown, the current size."""
    if one.packing.usual_bytes is not None:
        return one.packing.usual_bytes
    message = one.channel.read(sim)
    return 0 if message is None else len(one.packing.pack(message))


def _log_error(done: Future[Any]) -> None:
    error = None if done.cancelled() else done.exception()
    if error is not None:
        logger.warning("a command that has arrived failed: %s", error)
