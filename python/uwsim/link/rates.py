"""Determines how often each channel is sent, so that a modem can carry all of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from itertools import groupby

from uwsim.channels.channel import COMMAND, INSTRUMENT, PANEL, PICTURE, PING
from uwsim.link.carried import Carried
from uwsim.scenario.spec.link import Access, ModemModel

WANTED_HZ = {COMMAND: 10.0, PANEL: 1.0, INSTRUMENT: 1.0, PING: 1.0, PICTURE: 0.5}
"""Desired rates of channels by priority; higher rates would only make other channels wait."""
SHARE = 0.6
"""Share of the remaining capacity that the channels of one priority may use."""
FULL = 0.9
"""Share of the unused capacity that the last channels may use in addition."""
EVEN_S = 10.0
"""Channels of one priority have equal rates if each can be sent at least once in this time.

Otherwise each in turn gets SHARE of the remaining capacity.
"""
ALOHA_PEAK = 0.5 / math.e
"""The highest throughput of pure ALOHA, as a share of time: 18 % (Abramson 1970)."""
LONGEST_S = 120.0
"""Longest time between messages; a channel that could only be sent less often is not sent."""


def airtime_share(modem: ModemModel, access: Access, nodes: int) -> float:
    """Return the share of time during which each of `nodes` nodes can transmit successfully."""
    if access == "aloha":
        return ALOHA_PEAK / nodes
    return modem.slot_s / (modem.slot_s + modem.guard_s) / nodes


def airtime_s(modem: ModemModel, access: Access, size: int) -> float:
    """Return the time [s] for which a message of `size` bytes occupies the modem. TDMA packets do not span slots."""
    full, rest = divmod(size, modem.packet_bytes)
    packets = [modem.packet_bytes] * full + ([rest] if rest or not full else [])
    lengths_s = [modem.packet_s(part) for part in packets]
    if access == "aloha":
        return sum(lengths_s)
    return sum(modem.slot_s / math.floor(modem.slot_s / length_s + 1e-9) for length_s in lengths_s)


def send_rates(
    carried: Iterable[Carried],
    sizes: Mapping[str, int],
    modem: ModemModel,
    access: Access,
    nodes: int,
    *,
    times: Mapping[str, int] | None = None,
    taken: float = 0.0,
) -> dict[str, float]:
    """Return the rates [Hz] of a vehicle's channels, keyed by name, without the channels that cannot be sent.

    Capacity is assigned by priority: the channels of one priority get their desired rates, but at most SHARE of the
    remaining capacity. The last priority that gets any capacity also gets the unused capacity. Pictures take turns, so
    the rate returned for each of them is the rate of all pictures together. sizes: packed message sizes in bytes.
    times: how many times each message is sent, by default once. taken: share of time used by the vehicle's instruments.
    Acknowledgements and retransmissions are not allowed for.
    """
    left = max(airtime_share(modem, access, nodes) - taken, 0.0)
    times = times or {}
    rates: dict[str, float] = {}
    grown: dict[str, float] = {}
    by_priority = groupby(sorted(carried, key=lambda one: one.priority), lambda one: one.priority)
    for priority, group in by_priority:
        names = [one.channel.name for one in group]
        costs_s = {name: times.get(name, 1) * airtime_s(modem, access, sizes[name]) for name in names}
        wanted, budget = WANTED_HZ[priority], SHARE * left
        if priority == PICTURE:
            own = dict.fromkeys(costs_s, min(wanted, budget / max(costs_s.values())))
        else:
            own = _shared_out(costs_s, wanted, budget)
        own = {name: rate for name, rate in own.items() if rate * LONGEST_S >= 1.0}
        if priority != PICTURE:
            used = sum(rate * costs_s[name] for name, rate in own.items())
            left -= used
        if own:
            rates |= own
            unused = 0.0 if priority == PICTURE else FULL * left / used
            grown = {name: min(wanted, rate * (1.0 + unused)) for name, rate in own.items()}
    return rates | grown


def _shared_out(costs_s: Mapping[str, float], wanted_hz: float, budget: float) -> dict[str, float]:
    """Return rates for channels of one priority.

    All rates are equal unless that rate would be too low. In that case, each channel in turn gets SHARE of the rest.
    """
    even_hz = min(wanted_hz, budget / sum(costs_s.values()))
    if even_hz * EVEN_S >= 1.0:
        return dict.fromkeys(costs_s, even_hz)
    rates: dict[str, float] = {}
    last = list(costs_s)[-1]
    for name, cost_s in costs_s.items():
        rate_hz = min(wanted_hz, (1.0 if name == last else SHARE) * budget / cost_s)
        if rate_hz * LONGEST_S >= 1.0:
            rates[name] = rate_hz
            budget -= rate_hz * cost_s
    return rates
