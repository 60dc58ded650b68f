"""Gravity by latitude: published values, a judge's oceanographic formula, and all that has weight."""

import math
from pathlib import Path

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.scenario.build.earth import STANDARD_M_S2, gravity_m_s2
from uwsim.scenario.spec.settings import Earth

SCENE = """
name: place
EARTH
mission_time_s: 600
water: {density_kg_m3: 1000, compressible: false, surface: {kind: airy, amplitude_m: 0.1, period_s: 4}}
terrain: {source: noise, size_m: [60, 60], spacing_m: 1, bed_depth_m: 60}
station: {position_m: [-6, 0, 0], dock_m: [0, 0, -30]}
vehicles: [{name: rov, model: rov, start: station, trim: {net_buoyancy_n: 20}}]
"""


def at(folder: Path, latitude_deg: float | None) -> Simulator:
    earth = "" if latitude_deg is None else f"earth: {{latitude_deg: {latitude_deg}, longitude_deg: 5.9}}"
    (folder / "place.yaml").write_text(SCENE.replace("EARTH", earth))
    return Simulator(folder / "place.yaml")


def test_normal_gravity_is_wgs_84_s():
    """TR8350.2, table 3.4: theoretical gravity at the equator and the poles; GRS 80 is next to it at 45 deg."""
    assert gravity_m_s2(Earth(latitude_deg=0, longitude_deg=0)) == pytest.approx(9.7803253359, abs=1e-10)
    assert gravity_m_s2(Earth(latitude_deg=45, longitude_deg=0)) == pytest.approx(9.806199203, abs=2e-6)
    near_pole = gravity_m_s2(Earth(latitude_deg=89, longitude_deg=0))
    assert near_pole == pytest.approx(9.8321849378 - 0.0519 * math.radians(1) ** 2, abs=1e-5)
    assert gravity_m_s2(None) == STANDARD_M_S2 == 9.80665


@pytest.mark.parametrize("latitude_deg", [-70, -12, 0, 33, 60, 88])
def test_oceanographers_have_the_same_at_the_surface(latitude_deg):
    gsw = pytest.importorskip("gsw", reason="needs gsw, the TEOS-10 library, which is not a dependency")
    found = gravity_m_s2(Earth(latitude_deg=latitude_deg, longitude_deg=0))
    assert found == pytest.approx(float(gsw.grav(latitude_deg, 0.0)), abs=3e-6)


def test_all_that_has_weight_follows(tmp_path):
    there, here = at(tmp_path, 0.0), at(tmp_path, None)
    g_m_s2 = there.world.water.gravity_m_s2
    assert g_m_s2 == pytest.approx(9.7803253359, abs=1e-10)
    assert here.world.water.gravity_m_s2 == STANDARD_M_S2
    # Pressure is rho g d, the IMU at rest measures g, and the trim's lift is in newtons of this place.
    still_pa = there.world.water.pressure_pa(-30.0) - 101325.0
    assert still_pa == pytest.approx(1000.0 * g_m_s2 * 30.0, rel=1e-9)
    assert there.rov.sensors["imu"].read(noise=False).linear_acceleration_m_s2[2] == pytest.approx(g_m_s2, abs=1e-6)
    assert there.rov.control.net_buoyancy_n == pytest.approx(20.0, abs=1e-6)
    # A deep-water wave of 4 s is g T^2 / (2 pi) long: its motion falls by e in T^2 g / (4 pi^2).
    for sim, gravity in ((there, g_m_s2), (here, STANDARD_M_S2)):
        speeds = [np.abs([sim.world.water.velocity_m_s([(0.0, 0.0, z)], 0.05 * k) for k in range(81)]).max()
                  for z in (-2.0, -6.0)]  # fmt: skip
        decay_1_m = math.log(speeds[0] / speeds[1]) / 4.0
        assert 4.0**2 * gravity / (4.0 * math.pi**2) * decay_1_m == pytest.approx(1.0, abs=5e-4)


def test_the_filter_s_topic_without_gravity_is_zero_at_rest(tmp_path):
    from uwsim.channels import Table

    sim = at(tmp_path, 80.0)
    topics = {channel.name: channel for channel in Table(sim).channels}
    (name,) = (each for each in topics if each.endswith("imu/accel"))
    vertical = [topics[name].read(sim).accel.accel.linear.z]
    assert np.mean(vertical) == pytest.approx(0.0, abs=0.1)
