"""The link suite: the range at which half of a modem's packets arrive, compared with the sonar equation.

Its parts are native tests: travel times, arcs and shadow zones (Arrivals), levels and noise (Reception), losses at the
bottom (BoundaryLoss) and error rates (PacketError).
"""

from __future__ import annotations

import math

import numpy as np

from uwsim import _core
from uwsim.evidence.validate.check import Check, relative
from uwsim.scenario.build.station import modem_spec
from uwsim.scenario.spec.link import load_modem


def run() -> list[Check]:
    """Return the check, in deep, uniform water."""
    spec = _open_spec()
    heard_in, nothing = _core.LinkWater(spec, _even_water()), _core.RayScene(_core.World())
    bits = 8.0 * (spec.modem.packet_bytes + spec.modem.header_bytes)
    # Half of the packets are lost if 1 - (1 - Pb)^n = 1/2, with Pb = 1 / (2 + gamma) for FSK in Rayleigh fading.
    gamma = 1.0 / -math.expm1(-math.log(2.0) / bits) - 2.0
    snr_db = 10.0 * math.log10(gamma * spec.modem.bit_rate_bit_s / spec.modem.bandwidth_hz) - spec.modem.coding_gain_db
    allowed_db = spec.modem.source_level_db - _noise_db(spec) - snr_db
    alpha = 1e-3 * _core.absorption_db_km(spec.modem.frequency_hz, 10.0, 35.0, 5000.0)
    ranges_m = np.geomspace(10.0, 50_000.0, 200_001)
    expected_m = float(np.interp(allowed_db, 20.0 * np.log10(ranges_m) + alpha * ranges_m, ranges_m))
    far_m = np.geomspace(0.5 * expected_m, 2.0 * expected_m, 400)
    sender, packet_bytes = (0.0, 0.0, -5000.0), spec.modem.packet_bytes
    heard = (heard_in.receive(nothing, sender, (r, 0.0, -5000.0)) for r in far_m)
    lost = [reception.packet_loss(spec.modem, packet_bytes) for reception in heard]
    got_m = float(np.interp(0.5, lost, far_m))
    return [relative("range at 50 % delivery", "micromodem in the ocean", expected_m, got_m, 0.02, "m")]


def _open_spec() -> _core.LinkSpec:
    spec = _core.LinkSpec()
    spec.modem = modem_spec(load_modem("micromodem"))
    spec.wind_m_s, spec.shipping = 5.0, 0.5
    return spec


def _noise_db(spec: _core.LinkSpec) -> float:
    """Return the total noise of sea and receiver in the modem band [dB re 1 uPa]."""
    ambient_db = _core.ambient_noise_db_hz(spec.modem.frequency_hz, spec.wind_m_s, spec.shipping)
    density = 10.0 ** (0.1 * ambient_db) + 10.0 ** (0.1 * spec.modem.receiver_noise_db_hz)
    return 10.0 * math.log10(density * spec.modem.bandwidth_hz)


def _even_water() -> _core.Water:
    """Return an ocean of uniform temperature, in which the speed of sound increases with depth alone."""
    water = _core.Water()
    water.surface_temperature_deg_c = water.bottom_temperature_deg_c = 10.0
    water.salinity_psu = 35.0
    water.bottom_depth_m = 10_000.0
    return water
