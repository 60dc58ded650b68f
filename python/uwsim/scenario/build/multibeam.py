"""A multibeam model for the core: its fan, and its acoustic parameters in physics mode."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uwsim import _core
from uwsim.scenario.spec.material import ROCK, Backscatter
from uwsim.scenario.spec.sonar import ACOUSTIC, SonarModel
from uwsim.scenario.spec.water_target import School, Seep


def multibeam_model(
    model: SonarModel, frequency_hz: float | None = None, *, gain_db: float = 0.0
) -> _core.MultibeamModel:
    """Return the fan at a frequency; None selects a model's only frequency. Raises ValueError."""
    band = model.band(frequency_hz)
    return _core.MultibeamModel(
        name=model.description or model.name,
        number=model.wire_number or 0,
        beams=model.beams,
        field_of_view_rad=math.radians(band.field_of_view_deg),
        range_max_m=band.range_max_m,
        range_limit_m=band.range_limit_m,
        frequency_hz=band.frequency_hz,
        dual_swath=model.dual_swath,
        ping_rate_max_hz=model.ping_rate_max_hz,
        tilt_rate_rad_s=math.radians(model.tilt_rate_deg_s),
        receiver_tilt_rad=math.radians(model.receiver_tilt_deg or 0.0) if model.receivers == 2 else 0.0,
        gain_db=gain_db,
    )


def acoustic_spec(
    model: SonarModel,
    frequency_hz: float | None = None,
    *,
    bending: bool = False,
    rays_per_beam: int = 8,
    bottoms: Sequence[Backscatter] = (),
    volume_strength_db: float | None = None,
    water_targets: Sequence[School | Seep] = (),
) -> _core.AcousticSpec:
    """Return the physics-mode parameters at a frequency.

    bottoms: backscatter by label; labels beyond its end are treated as rock. volume_strength_db: backscatter of the
    water. Raises ValueError.
    """
    band = model.acoustic_band(frequency_hz)
    spec, parameters = _core.AcousticSpec(), _core.SonarParameters()
    for key in ACOUSTIC:
        value = getattr(band, key)
        setattr(parameters, key.replace("_deg", "_rad"), math.radians(value) if key.endswith("_deg") else value)
    parameters.frequency_hz = band.frequency_hz
    parameters.noise_level_db = model.noise.level_db
    parameters.detection_threshold_db = model.noise.detection_threshold_db
    parameters.check()
    spec.parameters = parameters
    spec.rays_per_beam = rays_per_beam
    spec.false_detections = model.noise.false_detections
    spec.range_noise = model.noise.range
    spec.bending = bending
    spec.multipath = model.multipath
    spec.volume_strength_db = volume_strength_db
    spec.targets = [targets(group) for group in water_targets]
    spec.bottom = bottom_material(ROCK)
    spec.materials = [bottom_material(bottom) for bottom in bottoms]
    return spec


def bottom_material(backscatter: Backscatter) -> _core.BottomMaterial:
    """Convert a surface's acoustic backscatter to a core object."""
    ripples_rad = None if backscatter.ripples_deg is None else math.radians(backscatter.ripples_deg)
    return _core.BottomMaterial(
        backscatter.strength_db, backscatter.relief, backscatter.seabed, backscatter.fluid, ripples_rad
    )


def targets(group: School | Seep) -> _core.WaterTargets:
    """Convert a school or a seep to a core object."""
    if isinstance(group, School):
        size_m, rise_m_s = group.size_m, 0.0
    else:
        size_m, rise_m_s = (group.top_diameter_m, group.top_diameter_m, group.height_m), group.rise_m_s
    return _core.WaterTargets(
        group.name,
        isinstance(group, Seep),
        group.position_m,
        size_m,
        group.count,
        group.target_strength_db,
        rise_m_s,
    )
