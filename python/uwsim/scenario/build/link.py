"""The link between station and vehicles as the core's LinkSpec."""

from __future__ import annotations

from collections.abc import Sequence

from uwsim import _core
from uwsim.scenario.build.station import in_world
from uwsim.scenario.spec.link import BOTTOMS, LinkSetup
from uwsim.scenario.spec.modem import ModemModel
from uwsim.scenario.spec.station import Station

KINDS = {"cable": _core.LinkKind.CABLE, "ideal": _core.LinkKind.IDEAL, "modem": _core.LinkKind.MODEM}
ACCESS = {"aloha": _core.MediumAccess.ALOHA, "tdma": _core.MediumAccess.TDMA}
MODULATION = {"psk": _core.Modulation.PSK, "fsk": _core.Modulation.FSK}
AS_THEY_ARE = (
    "latency_s", "packet_bytes", "header_bytes", "preamble_s", "receiver_noise_db_hz", "fading", "coding_gain_db",
    "multipath_window_s", "symbol_s", "speed_max_m_s", "slot_s", "guard_s", "backoff_s", "queue_bytes",
    "retransmissions", "acknowledgement_bytes",
)  # fmt: skip


def modem_spec(modem: ModemModel, access: str | None = None) -> _core.ModemSpec:
    """Return the modem's parameters. access: overrides the modem's access scheme. Not for modems of kind `none`."""
    spec = _core.ModemSpec()
    spec.kind = KINDS[modem.kind]
    spec.access = ACCESS[access or modem.access]
    spec.modulation = MODULATION[modem.modulation]
    spec.bit_rate_bit_s = modem.bit_rate_bit_s or 0.0
    for key in AS_THEY_ARE:
        setattr(spec, key, getattr(modem, key))
    for key in ("frequency_hz", "bandwidth_hz", "source_level_db"):
        value = getattr(modem, key)
        if value is not None:
            setattr(spec, key, value)
    return spec


def link_spec(link: LinkSetup, station: Station, vehicles: Sequence[str] = ()) -> _core.LinkSpec | None:
    """Return the link, or None if messages are delivered immediately. vehicles: names, for the relays."""
    if link.modem.kind == "none":
        return None
    spec = _core.LinkSpec()
    spec.modem = modem_spec(link.modem, link.access)
    if link.retransmissions is not None:
        spec.modem.retransmissions = link.retransmissions
    nodes = {name: 1 + index for index, name in enumerate(vehicles)}
    spec.relays = [0, *(nodes[link.relays[name]] if name in link.relays else 0 for name in vehicles)]
    spec.station_transducer_world_m = in_world(station, link.station_transducer_m)
    spec.wind_m_s = link.wind_m_s
    spec.shipping = link.shipping
    spec.set_bottom(*BOTTOMS[link.bottom])
    spec.faults = [_core.LinkFault(fault.from_s, fault.until_s, fault.loss) for fault in link.faults]
    return spec
