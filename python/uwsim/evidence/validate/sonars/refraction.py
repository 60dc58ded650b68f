"""Checks the "smile" of a flat bed that is sounded with a wrong profile against Snell's circle.

The circle itself is a native test, SoundPath.UnderAConstantGradientThePathIsSnellsCircle.
"""

from __future__ import annotations

import math

import numpy as np

from uwsim import _core
from uwsim.evidence.validate.check import Check, along, relative
from uwsim.evidence.validate.sonars.instrument import LOOKING_DOWN_XYZW, flat_world
from uwsim.instruments.sonars.soundings import beam_directions, sound_points

GROUP = "refraction, constant gradient"
SURFACE_M_S, GRADIENT_1_S, BED_M = 1500.0, -0.5, 60.0


def travel_s(dip_rad: float) -> float:
    """Return the one-way travel time from surface to bed along Snell's circle."""
    bed_m_s = SURFACE_M_S + GRADIENT_1_S * BED_M
    arrival_rad = math.acos(math.cos(dip_rad) * bed_m_s / SURFACE_M_S)
    slowing = (1 + math.sin(dip_rad)) * bed_m_s / ((1 + math.sin(arrival_rad)) * SURFACE_M_S)
    return math.log(slowing) / GRADIENT_1_S


def smile_checks() -> list[Check]:
    """Check physics mode with bending over a flat bed, sounded with the constant speed of sound at the head."""
    ping, sonar = bent_ping()
    wrong_m = sound_points(ping, _core.SoundSpeedProfile.even(sonar.profile.at(0.0)))[:, 2]
    right_m = sound_points(ping, sonar.profile)[:, 2]
    dips = np.arcsin(np.clip(-beam_directions(ping)[:, 2], -1, 1))
    expected_m = np.array([-SURFACE_M_S * travel_s(dip) * math.sin(dip) for dip in dips])
    bent_m = float(wrong_m[0] - np.median(wrong_m))
    closed_m = float(expected_m[0] - np.median(expected_m))
    return [
        along(GROUP, "flat bed, true profile", np.full(len(dips), -BED_M), right_m, BED_M, 2e-3, "m"),
        along(GROUP, "flat bed, constant speed assumed", expected_m, wrong_m, BED_M, 2e-3, "m",
              x=np.degrees(dips), across="dip of the beam [deg]"),
        relative(GROUP, "the smile: outermost beam above the median", closed_m, bent_m, 0.05, "m"),
    ]  # fmt: skip


def bent_ping() -> tuple[_core.PhysicsPing, _core.AcousticMultibeam]:
    """Return a ping straight down from the surface, 120 degrees wide and almost noise-free, and its sonar."""
    fan = _core.MultibeamModel(
        name="refraction", beams=121, field_of_view_rad=math.radians(120), range_max_m=400.0, frequency_hz=400e3
    )
    spec, parameters = _core.AcousticSpec(), _core.SonarParameters()
    parameters.source_level_db = 240.0
    parameters.beam_width_along_rad = parameters.beam_width_across_rad = 0.005
    spec.parameters = parameters
    spec.false_detections = spec.range_noise = False
    spec.bending = True
    water = _core.Water()
    depths = [0.0, 100.0]
    speeds = [SURFACE_M_S + GRADIENT_1_S * depth for depth in depths]
    water.profile = _core.WaterProfile(depths, [8.0, 8.0], [0.0, 0.0], [1000.0, 1000.0], speeds)
    sonar = _core.AcousticMultibeam(fan, spec, water)
    return sonar.ping(_core.RayScene(flat_world(BED_M)), (0.0, 0.0, 0.0), LOOKING_DOWN_XYZW), sonar
