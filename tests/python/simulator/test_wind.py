"""The wind: its gusts against the spectra by name, its force on a hull in closed form, and what is refused."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from sites import lake
from uwsim import Simulator
from uwsim.scenario import load
from uwsim.scenario.build.wind import LEAST_HZ, MOST_HZ, gusts
from uwsim.scenario.spec.water_parts import Wind


def npd(f: float, speed: float) -> float:
    """Return ISO 19901-1's density [m2/s2/Hz] 10 m above the water."""
    return 320 * (speed / 10) ** 2 / (1 + (172 * f * (speed / 10) ** -0.75) ** 0.468) ** (5 / (3 * 0.468))


def davenport(f: float, speed: float) -> float:
    x = 1200 * f / speed
    return 4 * 0.0015 * speed**2 * x**2 / (1 + x**2) ** (4 / 3) / f


@pytest.mark.parametrize(("name", "spectrum", "speed"), [("npd", npd, 18.0), ("davenport", davenport, 6.0)])
def test_gusts_have_the_spectrum_of_their_name(name: str, spectrum, speed: float) -> None:
    """That of the series which the harmonics sum to, not of their amplitudes."""
    seeds, total, bands = 20, [], []
    time = np.arange(0.0, 6000.0, 0.8)
    for seed in range(seeds):
        amplitude, omega, phase = gusts(Wind(speed_m_s=speed, gusts=name), seed).T
        series = np.cos(np.outer(time, omega) + phase) @ amplitude
        total.append(series.var())
        density = 2 * 0.8 / len(time) * np.abs(np.fft.rfft(series)) ** 2
        frequency = np.fft.rfftfreq(len(time), 0.8)
        edges = np.geomspace(0.003, 0.3, 6)
        within = [(frequency >= low) & (frequency < high) for low, high in pairwise(edges)]
        bands.append([density[one].sum() * frequency[1] for one in within])
    expected = quad(spectrum, LEAST_HZ, MOST_HZ, args=(speed,), limit=200)[0]
    assert np.mean(total) == pytest.approx(expected, rel=0.03)
    for measured, low, high in zip(np.mean(bands, axis=0), edges[:-1], edges[1:], strict=True):
        assert measured == pytest.approx(quad(spectrum, low, high, args=(speed,))[0], rel=0.06)


@pytest.mark.parametrize("speed", [4.0, 9.0])
def test_a_drifting_boat_goes_before_the_wind_as_its_drag_allows(speed: float) -> None:
    """Windage in surge is the drag ahead: 1/2 rho_a c A (w - u)^2 = 77.55 u."""
    wind = {"speed_m_s": speed, "heading_deg": 0.0}
    sim = Simulator(lake("otter", wind=wind), seed=1)
    sim.advance(60.0)
    u = float(sim.rov.velocity.linear_body_m_s[0])
    air = speed * (0.15 / 10) ** (1 / 7)
    assert 0.5 * 1.225 * 0.7 * 0.17 * (air - u) ** 2 == pytest.approx(77.55 * u, rel=0.02)


def test_without_windage_no_wind_is_felt() -> None:
    still, windy = (
        Simulator(lake("rov", **change), seed=1) for change in ({}, {"wind": {"speed_m_s": 20.0, "gusts": "npd"}})
    )
    for sim in (still, windy):
        sim.advance(5.0)
    assert np.array_equal(still.rov.pose.world_from_body, windy.rov.pose.world_from_body)


def test_optics_and_link_have_the_wind_unless_they_have_their_own() -> None:
    wind, link = {"speed_m_s": 9.0}, {"modem": "s2cm_hs"}
    common = lake("otter", wind=wind, link=link)
    assert common.link.wind_m_s == common.optics.wind_m_s == 9.0
    assert lake("otter", wind=wind, link=link | {"wind_m_s": 2.0}).link.wind_m_s == 2.0
    assert load("lake").wind is None


def test_windage_of_a_hull_that_sinks_is_refused() -> None:
    sail = {"frontal_area_m2": 1.0, "lateral_area_m2": 1.0, "length_m": 1.0, "height_m": 1.0}
    model = {"builds_on": "otter", "mass_kg": 300.0, "coefficients": None, "windage": sail}
    scenario = lake(model)
    with pytest.raises(ValueError, match="windage: is only for a hull that floats"):
        Simulator(scenario)
