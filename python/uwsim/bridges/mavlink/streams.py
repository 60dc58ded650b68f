"""Telemetry at the rates that ground stations request."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from uwsim.bridges.doors.datagrams import Address
from uwsim.bridges.mavlink.component import DENIED, DONE, Component, Given, Obey
from uwsim.bridges.mavlink.craft import Craft
from uwsim.bridges.mavlink.state import State
from uwsim.bridges.mavlink.telemetry import Figures, Kind

RATE_MAX_HZ, READING_MIN_HZ = 50.0, 10.0
NO_RATE_HZ = 1 / 60  # ArduPilot's longest interval is one minute
MICROSECONDS = 1e6
INTERVAL_IDS_MAX = 0xFFFF


class Streams:
    """Sends each kind of telemetry at its rate in simulated time, for all ground stations.

    The last request for a message determines its rate. Readings are taken at the fastest of these rates, but at 10 Hz
    or more. set_reading_rate: called with the rate of readings when it changes.
    """

    def __init__(
        self, craft: Craft, component: Component, kinds: Iterable[Kind], set_reading_rate: Callable[[float], object]
    ) -> None:
        self._craft, self._component, self._set_reading_rate = craft, component, set_reading_rate
        self._kinds = {kind.number: kind for kind in kinds}
        self._rates_hz = {kind.number: float(kind.rate_hz) for kind in self._kinds.values()}
        self._slots: dict[int, int] = {}
        self.reading_rate_hz = READING_MIN_HZ

    @property
    def commands(self) -> Mapping[int, Obey]:
        """The commands that this part executes, by MAV_CMD: SET_MESSAGE_INTERVAL and GET_MESSAGE_INTERVAL."""
        return {511: self._on_set_interval, 510: self._on_get_interval}

    def send(self, state: State) -> None:
        """Send the messages that are due."""
        figures = Figures(state, self._craft)
        for number, rate_hz in self._rates_hz.items():
            slot = int(state.time_s * rate_hz + 1e-6)
            if rate_hz and self._slots.get(number) != slot:
                self._slots[number] = slot
                for message in self._kinds[number].make(self._component.mav, figures):
                    self._component.send(message)

    def answer(self, number: int, value: float) -> Iterable[Any] | None:
        """Return the messages with an ID; see Answers."""
        kind = self._kinds.get(number)
        if kind is None:
            return None
        state = self._craft.state
        return [] if state is None else kind.make(self._component.mav, Figures(state, self._craft))

    def _on_set_interval(self, given: Given) -> int:
        """Set a message's interval [us]; 0 selects the default, and -1 disables it.

        Deny unknown IDs and excessive rates.
        """
        number, interval_us = given.integer(1), given.real(2)
        if number not in self._kinds or (interval_us < 0 and interval_us != -1):
            return DENIED
        if interval_us == 0:
            rate_hz = float(self._kinds[number].rate_hz)
        elif interval_us == -1:
            rate_hz = 0.0
        else:
            rate_hz = max(MICROSECONDS / interval_us, NO_RATE_HZ)
        if rate_hz > RATE_MAX_HZ:
            return DENIED
        self._set({number: rate_hz})
        return DONE

    def _on_get_interval(self, given: Given) -> int:
        number = given.integer(1)
        if not 0 <= number <= INTERVAL_IDS_MAX:
            return DENIED
        rate_hz = self._rates_hz.get(number)
        interval_us = 0 if rate_hz is None else round(MICROSECONDS / rate_hz) if rate_hz else -1
        given.replies.append(self._component.mav.message_interval_encode(number, interval_us))
        return DONE

    def on_request_data_stream(self, peer: Address, message: Any) -> None:
        """Set the rate of a group of messages (0: all messages), as older ground stations request it."""
        rate_hz = min(float(message.req_message_rate), RATE_MAX_HZ) if message.start_stop else 0.0
        self._set({n: rate_hz for n, kind in self._kinds.items() if message.req_stream_id in (0, kind.stream)})

    def _set(self, rates_hz: Mapping[int, float]) -> None:
        self._rates_hz.update(rates_hz)
        fastest_hz = max(READING_MIN_HZ, *self._rates_hz.values())
        if fastest_hz != self.reading_rate_hz:
            self.reading_rate_hz = fastest_hz
            self._set_reading_rate(fastest_hz)
