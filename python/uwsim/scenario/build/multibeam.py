"""A multibeam for the core, the labels of what its rays hit, and the chain from its pings to a map."""

from __future__ import annotations

import math
from collections.abc import Sequence

from uwsim import _core
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap, Wire, depth_string
from uwsim.scenario.build.arm import all_shaped_links
from uwsim.scenario.build.cover import plume_names
from uwsim.scenario.build.hull import hull_box_m
from uwsim.scenario.build.station import tether_specs
from uwsim.scenario.spec.material import ROCK, TETHER, Backscatter
from uwsim.scenario.spec.obstacle import BUBBLES
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.sonar import ACOUSTIC, SonarModel
from uwsim.scenario.spec.vehicle import VehicleModel
from uwsim.scenario.spec.water_parts import School, Seep


def label_names(scenario: Scenario) -> list[str]:
    """Return the names by label: World.label_names, vehicles, objects, life, plumes, links of arms, then tethers.

    An arm has a label for each link with a shape, `<vehicle> <shape>`, and a tether one for each of its elements, all
    with the name `<vehicle or object> tether`.
    """
    station = ["station"] if scenario.station.mesh is not None else []
    parts = (scenario.obstacles, scenario.cover, scenario.vehicles, scenario.objects, scenario.life or ())
    obstacles, cover, vehicles, objects, life = ([named.name for named in part] for part in parts)
    arms = [f"{body} {link.shape.name}" for body, link in all_shaped_links(scenario) if link.shape is not None]
    fixed = ["nothing", "terrain", *obstacles, *station, *cover]
    return [*fixed, *vehicles, *objects, *life, *plume_names(scenario), *arms, *_tethers(scenario)]


def backscatter_by_label(scenario: Scenario) -> list[Backscatter]:
    """Return the backscatter of each labelled surface, in the order of `label_names`."""
    station = [scenario.station.material] if scenario.station.mesh is not None else []
    vehicles = [vehicle.model.material for vehicle in scenario.vehicles]
    vehicles += [body.shape.material for body in scenario.objects]
    vehicles += [animals.material for animals in scenario.life or ()]
    vehicles += [BUBBLES for _ in plume_names(scenario)]
    vehicles += [link.shape.material for _, link in all_shaped_links(scenario) if link.shape is not None]
    obstacles, cover = [one.surface for one in scenario.obstacles], [layer.material for layer in scenario.cover]
    solids = (material.backscatter for material in (*obstacles, *station, *cover, *vehicles))
    tethers = [TETHER] * len(_tethers(scenario))
    return [ROCK, scenario.ground.backscatter, *solids, *tethers]


def _tethers(scenario: Scenario) -> list[str]:
    return [f"{name} tether" for name, spec in tether_specs(scenario).items() for _ in range(spec.tubes)]


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


VOXEL_M = 0.2
"""The edge of a map's voxels in a scenario without a survey."""


def ping_chain(
    scenario: Scenario,
    vehicle: VehicleModel,
    model: _core.MultibeamModel,
    *,
    in_physics: bool,
    outlier_filter: bool | None = None,
    voxel_m: float | None = None,
    filler: MapFiller | None = None,
    wire: Wire | None = None,
) -> PingToMap:
    """Return the chain for the pings of a vehicle's multibeam, for every map that is made of them.

    in_physics: whether the sonar is in physics mode. outlier_filter, voxel_m: override the survey's. filler: see
    PingToMap. wire: by default, see depth_string.
    """
    survey = scenario.survey
    if outlier_filter is None:
        outlier_filter = survey.outlier_filter if survey is not None else None
    filters = in_physics if outlier_filter is None else outlier_filter
    limit_m = None
    if filters and in_physics:
        limit_m = survey.max_uncertainty_m if survey is not None else None
        limit_m = 0.5 * (voxel_m or map_voxel_m(scenario)) if limit_m is None else limit_m
    return PingToMap(
        model,
        hull_box_m(vehicle),
        filler,
        wire=wire or depth_string(model),
        decodes=True,
        outlier_filter=filters,
        max_uncertainty_m=limit_m,
    )


def map_voxel_m(scenario: Scenario) -> float:
    """Return the edge of the voxels of a scenario's maps: its survey's, or VOXEL_M without a survey."""
    return VOXEL_M if scenario.survey is None else scenario.survey.voxel_m
