"""The link between station and vehicles as the core's LinkSpec."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim import _core
from uwsim.scenario.build.station import in_world
from uwsim.scenario.read.errors import ScenarioError
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

TRANSDUCER_DEPTH_M = 3.0


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


def station_transducer(link: LinkSetup, station: Station, world: _core.World) -> NDArray[np.float64]:
    """Return the station's transducer (3,) [m], in the world's or its carrier's frame.

    Raises ScenarioError for one above the water, and for a modem whose station stands on land, with no default.
    """
    if link.station_transducer_m is not None:
        given = in_world(station, link.station_transducer_m)
        if station.carrier is None and given[2] > 0.0:
            x, y, z = link.station_transducer_m
            raise ScenarioError(
                f"link.station_transducer_m = [{x:g}, {y:g}, {z:g}] m: is {given[2]:g} m above the water, since the "
                f"station is at z = {station.position_m[2]:g} m: must be under water",
                at=("link", "station_transducer_m"),
            )
        return given
    x, y, _ = station.position_m
    if station.carrier is not None:
        return np.array([x, y, -TRANSDUCER_DEPTH_M])
    bed_m = float(world.height_at(np.array([[x, y]]))[0])  # NaN beyond the terrain
    if bed_m >= 0.0 and link.modem.kind == "modem":
        raise ScenarioError(
            f"link.modem = {link.modem.name}: the station at ({x:g}, {y:g}) m stands on land, {bed_m:.3g} m above the "
            "water: give link.station_transducer_m, under water",
            at=("link", "modem"),
        )
    return np.array([x, y, min(0.5 * bed_m, 0.0) if bed_m > -TRANSDUCER_DEPTH_M else -TRANSDUCER_DEPTH_M])


def link_spec(link: LinkSetup, station: Station, world: _core.World) -> _core.LinkSpec | None:
    """Return the link, or None if messages are delivered at once. Raises ScenarioError, see `station_transducer`."""
    if link.modem.kind == "none":
        return None
    spec = _core.LinkSpec()
    spec.modem = modem_spec(link.modem, link.access)
    if link.retransmissions is not None:
        spec.modem.retransmissions = link.retransmissions
    spec.station_transducer_world_m = station_transducer(link, station, world)
    spec.wind_m_s = link.wind_m_s
    spec.shipping = link.shipping
    spec.set_bottom(*BOTTOMS[link.bottom])
    spec.faults = [_core.LinkFault(fault.from_s, fault.until_s, fault.loss) for fault in link.faults]
    return spec
