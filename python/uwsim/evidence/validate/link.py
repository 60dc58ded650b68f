"""The link suite: travel times, levels and errors compared with closed forms.

The water is uniform or has a constant gradient, with no bed.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from uwsim import _core
from uwsim.evidence.validate.check import Check, relative, within
from uwsim.scenario.build.link import modem_spec
from uwsim.scenario.spec.link import BOTTOMS
from uwsim.scenario.spec.modem import load_modem

SLOPE_1_S = 0.02  # gradient of the speed of sound, which increases with depth
SURFACE_M_S = 1480.0
SAND = BOTTOMS["sand"]


def run(out: Path | None = None) -> list[Check]:
    """Return the checks of the suite, which draws no curves."""
    return [*path_checks(), *level_checks(), *error_checks(), *delivery_checks()]


def path_checks() -> list[Check]:
    """Check travel times on straight and reflected paths and on arcs in a gradient, and the edge of a shadow zone."""
    group, even = "travel time", _core.SoundSpeedProfile.even(1500.0)
    checks = []
    for ray in _core.arrivals(even, 12.0, 30.0, 400.0, 45.0, 25e3, SAND, most_bounces=2):
        rise = {(0, 0): 18.0, (1, 0): 42.0, (0, 1): 48.0}.get((ray.surface_bounces, ray.bottom_bounces))
        if rise is None:
            rise = 72.0 if ray.launch_dip_rad < 0 else 108.0
        name = f"{ray.surface_bounces} surface, {ray.bottom_bounces} bottom bounces"
        checks.append(relative(group, name, math.hypot(400.0, rise) / 1500.0, ray.time_s, 1e-9, "s"))
    profile = _core.SoundSpeedProfile([0.0, 4000.0], [SURFACE_M_S, SURFACE_M_S + 4000.0 * SLOPE_1_S])
    for far_m in (500.0, 2000.0, 5000.0):
        (ray,) = _direct(profile, 500.0, far_m)
        arc_s = 2.0 / SLOPE_1_S * math.asinh(0.5 * SLOPE_1_S * far_m / profile.at(500.0))
        checks.append(relative(group, f"arc over {far_m:g} m", arc_s, ray.time_s, 1e-6, "s"))
    down = _core.SoundSpeedProfile([0.0, 100.0], [1500.0, 1450.0])
    edge_m = 2.0 * math.sqrt(1500.0**2 - down.at(10.0) ** 2) / 0.5
    return [*checks, relative("shadow zone", "edge at 10 m depth, -0.5 1/s", edge_m, _shadow_edge_m(down), 1e-3, "m")]


def _shadow_edge_m(profile: _core.SoundSpeedProfile) -> float:
    """Return the range beyond which no direct ray connects two points at a depth of 10 m."""
    near, far = 1.0, 5000.0
    while far - near > 0.01:
        middle = 0.5 * (near + far)
        if _direct(profile, 10.0, middle):
            near = middle
        else:
            far = middle
    return near


def _direct(profile: _core.SoundSpeedProfile, depth_m: float, far_m: float) -> list[_core.Arrival]:
    """Return the arrivals that have not bounced, between two points at the same depth."""
    return _core.arrivals(profile, depth_m, depth_m, far_m, math.inf, 25e3, SAND, most_bounces=0)


def level_checks() -> list[Check]:
    """Check received levels and noise in deep, uniform water against the sonar equation."""
    spec, checks = _open_spec(), []
    water = _even_water()
    heard_in, nothing = _core.LinkWater(spec, water), _core.RayScene(_core.World())
    alpha = 1e-3 * _core.absorption_db_km(spec.modem.frequency_hz, 10.0, 35.0, 5000.0)
    for far_m in (100.0, 1000.0, 4000.0):
        heard = heard_in.receive(nothing, (0.0, 0.0, -5000.0), (far_m, 0.0, -5000.0))
        level = spec.modem.source_level_db - 20.0 * math.log10(far_m) - alpha * far_m
        checks.append(within("received level", f"{far_m:g} m", level, heard.signal_db, 1.0, 0.1, "dB"))
    expected = _noise_db(spec)
    spec.modem.source_level_db = 60.0  # no echo arrives from the surface
    quiet = _core.LinkWater(spec, water).receive(nothing, (0.0, 0.0, -5000.0), (100.0, 0.0, -5000.0)).noise_db
    checks.append(within("noise in the band", f"{spec.modem.bandwidth_hz:g} Hz", expected, quiet, 1.0, 0.2, "dB"))
    normal = (1.9 * 1.1 - 1.0) / (1.9 * 1.1 + 1.0)
    loss = _core.bottom_loss_db(1.9, 1.1, 0.0, 0.5 * math.pi)
    return [*checks, relative("bottom loss", "sand, straight down", -20.0 * math.log10(normal), loss, 1e-6, "dB")]


def error_checks() -> list[Check]:
    """Check bit error rates against values from textbook curves."""
    psk, fsk = _core.Modulation.PSK, _core.Modulation.FSK
    group = "bit error"
    return [
        relative(group, "PSK at 9.59 dB", 1e-5, _core.bit_error(psk, False, 10**0.959), 0.02),
        relative(group, "PSK at 6.79 dB", 1e-3, _core.bit_error(psk, False, 10**0.679), 0.02),
        relative(group, "FSK at 13.35 dB", 1e-5, _core.bit_error(fsk, False, 10**1.335), 0.03),
        relative(group, "PSK in Rayleigh fading at 24 dB", 1e-3, _core.bit_error(psk, True, 10**2.4), 0.02),
        relative(group, "FSK in Rayleigh fading at 30 dB", 1e-3, _core.bit_error(fsk, True, 10**3.0), 0.01),
    ]


def delivery_checks() -> list[Check]:
    """Check the range at which half of the packets are delivered against the sonar equation."""
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
    lost = [
        heard_in.receive(nothing, (0.0, 0.0, -5000.0), (r, 0.0, -5000.0)).packet_loss(
            spec.modem, spec.modem.packet_bytes
        )
        for r in far_m
    ]
    got_m = float(np.interp(0.5, lost, far_m))
    return [relative("range at 50 % delivery", "micromodem in the ocean", expected_m, got_m, 0.02, "m")]


def _noise_db(spec: _core.LinkSpec) -> float:
    """Return the total noise of sea and receiver in the modem band [dB re 1 uPa]."""
    ambient_db = _core.ambient_noise_db_hz(spec.modem.frequency_hz, spec.wind_m_s, spec.shipping)
    density = 10.0 ** (0.1 * ambient_db) + 10.0 ** (0.1 * spec.modem.receiver_noise_db_hz)
    return 10.0 * math.log10(density * spec.modem.bandwidth_hz)


def _open_spec() -> _core.LinkSpec:
    spec = _core.LinkSpec()
    spec.modem = modem_spec(load_modem("micromodem"))
    spec.wind_m_s, spec.shipping = 5.0, 0.5
    return spec


def _even_water() -> _core.Water:
    """Return an ocean of uniform temperature, in which the speed of sound increases with depth alone."""
    water = _core.Water()
    water.surface_temperature_deg_c = water.bottom_temperature_deg_c = 10.0
    water.salinity_psu = 35.0
    water.bottom_depth_m = 10_000.0
    return water
