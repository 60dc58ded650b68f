"""The processing chain from a vehicle's pings to a map, as the scenario's survey specifies it."""

from __future__ import annotations

from uwsim import _core
from uwsim.mapping.map_filler import MapFiller
from uwsim.mapping.ping_to_map import PingToMap, Wire, depth_string
from uwsim.scenario.build.hull import hull_box_m
from uwsim.scenario.spec.scenario import Scenario
from uwsim.scenario.spec.vehicle import VehicleModel

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
