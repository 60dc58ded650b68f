"""Compares the noise of simulated instruments with measurements by others at sea and in rivers.

Most of these values are in the instruments' files and are reproduced. Two follow from others: the scatter of the
RiverPro along x, y and z from the noise of its beams, and the scatter of the Workhorse along z from that along x and y.

Doppler velocity (DVL). Snapir, an ECA A18D with an RDI Workhorse Navigator, 13 runs off Haifa, 2022-06-08 (A-KIT data,
ansfl/A-KIT): robust standard deviations of 5 to 6 mm/s along x and y and 2 to 3 mm/s along z against the post-processed
inertial solution, in quiet runs at 1.6 to 2.1 m/s. RiverPro 1200 kHz, four beams at 20 degrees (MHKiT's example data):
the file's error velocity gives the noise of a beam; the same pings scatter by 0.05 m/s along x and y, and 0.018 m/s
along z (robust, from second differences).

Echosounder. Ping1D on a BlueROV2, 80,000 pings from 0.7 to 8 m (Seattle Aquarium, CCR_ROV_survey_methods): noise 1.2 mm
below 2 m and 2.4 mm above; 15 pings per second; no echo found in 6 to 13 % of the pings.

Acoustic positioning. Water Linked Underwater GPS on BlueROV2s, 46 min in three runs (clydemcqueen's
wl_ugps_acoustic_analysis, Seattle Aquarium's CCR_ROV_survey_methods): a fix every 0.5 s, 63 to 87 % of them valid;
ranges in steps of 0.047 m; bearing noise of 0.2 to 0.4 deg within 20 m.
"""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.texts.csv_table import read_csv
from uwsim.evidence.validate.check import Check, Curve, relative, within
from uwsim.evidence.validate.reality.kinds import AS_MEASURED, PREDICTED
from uwsim.scenario import Scenario, load_vehicle
from uwsim.scenario.spec.sensor import SensorMount
from uwsim.simulator.simulator import Simulator

FILE = "dvl/RiverPro_test01_decoded.csv"
WORKHORSE = "Workhorse Navigator, DVL"
PING1D, UGPS = f"{AS_MEASURED}: Ping1D, echosounder", f"{AS_MEASURED}: Underwater GPS"
SNAPIR_M_S = {"x": 0.0055, "y": 0.0055, "z": 0.0025}
RIVERPRO_M_S = {"x": 0.05, "y": 0.05, "z": 0.018}
RIVERPRO_SLANT_RAD = math.radians(20)
NO_LOCK_M_S = 32.0
ALTITUDE_M, BED_M, DURATION_S = 8.0, 50.0, 120.0
PING1D_M, PING1D_LOST = 0.0024, (0.06, 0.13)
ABOVE_BED_M, AT_UGPS_M = (0.0, 0.0, ALTITUDE_M - BED_M), (12.0, 9.0, -10.0)
UGPS_VALID, UGPS_STEP_M, UGPS_BEARING_DEG = (0.63, 0.87), 0.047, (0.2, 0.4)


def checks(data: Path) -> list[Check]:
    """Return the checks, with the measured and simulated noise of the RiverPro."""
    measured = error_velocity_m_s(read_beams(data / FILE), RIVERPRO_SLANT_RAD)
    beam_std = robust_std(measured) / (2 * _error_scale(RIVERPRO_SLANT_RAD))
    river, _ = _samples(_riverpro(beam_std))
    snapir, _ = _samples(load_vehicle("remus100").sensors["dvl"])
    height, arrived = _samples(load_vehicle("bluerov2_heavy").sensors["altitude"])
    shares = np.linspace(0.01, 0.99, 99)
    both = {"measured": measured, "simulated": error_velocity_m_s(river[:, 7:11].T, RIVERPRO_SLANT_RAD)}
    lines = {name: np.quantile(values, shares) for name, values in both.items()}
    spread = Curve(shares, lines, "share of the pings", "m/s", "error velocity")
    fixes, valid = _samples(load_vehicle("bluerov2_heavy").sensors["usbl"], AT_UGPS_M)
    steps = fixes[:, 3] / UGPS_STEP_M
    first, *others = _axis_checks(f"{PREDICTED}: RiverPro, DVL", river, RIVERPRO_M_S, 0.3)
    return [
        replace(first, curve=spread), *others,
        *_axis_checks(f"{PREDICTED}: {WORKHORSE}", snapir, SNAPIR_M_S, 0.15, "z"),
        *_axis_checks(f"{AS_MEASURED}: {WORKHORSE}", snapir, SNAPIR_M_S, 0.15, "xy"),
        relative(PING1D, "noise at 8 m", PING1D_M, noise(height[:, 0]), 0.15, "m"),
        _in_band(PING1D, "share of lost pings", PING1D_LOST, 1 - arrived),
        _in_band(UGPS, "share of valid fixes", UGPS_VALID, valid),
        within(UGPS, "range in steps of 0.047 m", round(steps[0]), float(steps[0]), 1.0, 1e-6),
        _in_band(UGPS, "noise of the azimuth", UGPS_BEARING_DEG, math.degrees(fixes[:, 4].std()), "deg"),
    ]  # fmt: skip


def read_beams(path: Path) -> Floats:
    """Return the bottom velocities (4, n) along the beams, for the pings in which all four are valid."""
    table = read_csv(path)
    beams = np.array([table.numbers(f"vel_bt_{beam}_m_s", may_lack=True) for beam in (1, 2, 3, 4)])
    return np.asarray(beams[:, (np.abs(beams) < NO_LOCK_M_S).all(axis=0)], np.float64)


def error_velocity_m_s(beams_m_s: Floats, slant_rad: float) -> Floats:
    """Return d (b1 + b2 - b3 - b4), zero except for noise, with d = 1 / (2 sqrt(2) sin slant) (Teledyne RDI)."""
    return np.asarray(_error_scale(slant_rad) * (np.array([1.0, 1.0, -1.0, -1.0]) @ beams_m_s), np.float64)


def robust_std(values: Floats) -> float:
    """Return the standard deviation of a normal distribution with the same median absolute deviation."""
    return 1.4826 * float(np.median(np.abs(values - np.median(values))))


def noise(values: Floats) -> float:
    """Return the standard deviation of white noise on a slowly varying quantity, from second differences."""
    return float(np.std(np.diff(values, 2))) / math.sqrt(6)


def _error_scale(slant_rad: float) -> float:
    return 1.0 / (2.0 * math.sqrt(2.0) * math.sin(slant_rad))


def _riverpro(beam_std_m_s: float) -> SensorMount:
    slant_deg = math.degrees(RIVERPRO_SLANT_RAD)
    channels = {"beam_velocity": {"std": beam_std_m_s, "quantum": 0.001}}
    return SensorMount.model_validate({"kind": "dvl", "rate_hz": 5, "beam_slant_deg": slant_deg, "channels": channels})


def _axis_checks(
    group: str, readings: Floats, expected_m_s: dict[str, float], tolerance: float, axes: str = "xyz"
) -> list[Check]:
    return [
        relative(group, f"noise along {axis}", expected, noise(readings[:, k]), tolerance, "m/s")
        for k, (axis, expected) in enumerate(expected_m_s.items())
        if axis in axes
    ]


def _in_band(group: str, name: str, band: tuple[float, float], got: float, unit: str = "") -> Check:
    return within(group, name, 0.5 * sum(band), got, 0.5 * (band[1] - band[0]), 1.0, unit)


def _samples(mount: SensorMount, at_m: tuple[float, float, float] = ABOVE_BED_M) -> tuple[Floats, float]:
    """Return a sensor's readings (n, width) on a vehicle at rest over a flat bed, and the share that arrived."""
    model = load_vehicle("bluerov2_heavy").model_copy(update={"sensors": {mount.kind: mount}})
    start = {"position_m": at_m}
    sim = Simulator(Scenario.model_validate({
        "name": "validation",
        "terrain": {"source": "noise", "size_m": [200, 200], "spacing_m": 100, "bed_depth_m": BED_M},
        "vehicles": [{"name": "rov", "model": model, "start": start, "trim": {"net_buoyancy_n": 0}}],
    }))  # fmt: skip
    stream = sim.rov.sensors[mount.kind].stream()
    sim.advance(DURATION_S)
    samples = stream.take()
    return samples.readings[samples.valid], len(samples) / (DURATION_S * (mount.rate_hz or 1.0))
