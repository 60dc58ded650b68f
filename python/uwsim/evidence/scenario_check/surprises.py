"""Finds likely oversights in a valid scenario, such as a wreck under the bed or a camera in opaque water."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.evidence.scenario_check.scene import ObstacleScene, Scene, VehicleScene
from uwsim.evidence.vehicle.surprises import vehicle_surprises
from uwsim.missions.heights import HIGHEST_Z_M
from uwsim.missions.water_ahead import recognised_ahead_m
from uwsim.scenario.build.multibeam import multibeam_model
from uwsim.scenario.build.scale import size_text
from uwsim.scenario.build.wind import RISING_SHARE
from uwsim.simulator.simulator import Simulator

SIGHT_M = 3.0
"""Visibility below which a warning is given."""
FLOATING_M = 0.3
"""Height above the bed beyond which a warning is given, since an obstacle appears to float."""
HANGING = ("ring", "line", "net")
"""Kinds that are meant to hang in the water."""
BURIED, HIDDEN = 0.6, 0.999
"""Shares of an obstacle's surface below the bed beyond which a warning is given, and it is invisible."""
TRIM_SHARE = 0.004
"""Net buoyancy, as a share of a vehicle's weight, beyond which a warning is given."""
FREE_M = 0.1
STOP_S = 2.0
"""Time in which a vehicle stops in front of what it sees."""
LONG_TERRAINS, TALL_M, TINY_M = 1.5, 100.0, 0.05
"""Limits beyond which an obstacle may be in the wrong unit.

LONG_TERRAINS: length relative to the terrain, where a wall around the terrain has its diagonal. TALL_M: height above
the water. TINY_M: size, about that of a fist.
"""


def surprises(sim: Simulator, scene: Scene) -> tuple[str, ...]:
    """Return a sentence about each likely oversight, with the line number in the file."""
    source = sim.scenario.source_file
    found: list[tuple[tuple[str | int, ...], str]] = []
    for index, obstacle in enumerate(scene.obstacles):
        found += [(("obstacles", index), text) for text in _of_obstacle(obstacle, scene)]
    for index, vehicle in enumerate(scene.vehicles):
        found += [(("vehicles", index), text) for text in _of_vehicle(sim, scene, vehicle, index)]
    found += [(("vehicles", index), text) for index, text in _near_each_other(scene)]
    found += [(("station",), text) for text in _of_station(scene)]
    found += [(("survey",), text) for text in _of_survey(sim)]
    found += [(("terrain",), text) for text in _of_bed(scene)]
    if scene.bed.dry_share > 0.9:
        found.append((("terrain",), f"{100 * scene.bed.dry_share:.0f} % of the terrain is above the water"))
    return tuple(f"{source.line_prefix(*keys)}{text}" for keys, text in found)


def _of_obstacle(obstacle: ObstacleScene, scene: Scene) -> Iterator[str]:
    name = f"{obstacle.kind} '{obstacle.name}'"
    if obstacle.beside_terrain:
        yield f"{name} reaches over the terrain's edge"
    yield from (f"{name} {text}" for text in _of_scale(obstacle, scene))
    if obstacle.buried_share > HIDDEN:
        deep_m = -obstacle.clearance_m
        yield f"{name} is all below the bed, by up to {deep_m:.1f} m: nothing sees or meets it; {_hint(obstacle)}"
    elif obstacle.kind != "pipeline" and obstacle.buried_share > BURIED:
        yield f"{name} is {100 * obstacle.buried_share:.0f} % below the bed; {_hint(obstacle)}"
    if obstacle.above_water_share > HIDDEN:
        yield f"{name} is all above the water"
    elif obstacle.kind in HANGING or obstacle.held or obstacle.highest_m >= 0.0:
        pass  # obstacles that reach the surface may float
    elif obstacle.clearance_m > FLOATING_M:
        yield f"{name} hangs {obstacle.clearance_m:.1f} m above the bed; {_hint(obstacle)}"


def _of_scale(obstacle: ObstacleScene, scene: Scene) -> Iterator[str]:
    west, south, east, north = scene.bed.extent_m
    size, longest_m = size_text(np.array(obstacle.size_m)), max(obstacle.size_m)
    question = "is its mesh in metres? see its scale" if obstacle.kind == "mesh" else "are its sizes in metres?"
    if longest_m > LONG_TERRAINS * max(east - west, north - south) or obstacle.highest_m > TALL_M:
        yield f"is {size}, in a terrain of {east - west:g} x {north - south:g} m: {question}"
    elif longest_m < TINY_M:
        yield f"is only {size}: {question}"


def _hint(obstacle: ObstacleScene) -> str:
    return "`on_bed: true` with z = 0 puts it on the bed"


def _of_vehicle(sim: Simulator, scene: Scene, vehicle: VehicleScene, index: int) -> Iterator[str]:
    name, entry = f"vehicle '{vehicle.name}'", sim.scenario.vehicles[index]
    if vehicle.beside_terrain:
        yield f"{name} starts with a part of its hull over the terrain's edge"
    if vehicle.altitude_m < 0.0:
        yield f"{name} starts {-vehicle.altitude_m:.2f} m in the ground"
    elif vehicle.docked and vehicle.free_m < FREE_M:
        yield f"{name} cannot leave the dock: a surface is {vehicle.free_m + vehicle.radius_m:.2f} m from its exit"
    elif not vehicle.docked and vehicle.free_m < FREE_M:
        yield f"{name} starts {vehicle.free_m:.2f} m from a surface"
    if vehicle.position_m[2] > vehicle.radius_m:
        yield f"{name} starts {vehicle.position_m[2]:.1f} m above the water"
    yield from _of_trim(vehicle)
    model_file = entry.model.source_file
    for keys, text in vehicle_surprises(vehicle.figures):
        yield f"{name}: {model_file.line_prefix(*keys) if keys else model_file.file_prefix}{text}"
    if not vehicle.holds_current:
        yield f"{name} cannot swim against the current at its start, {vehicle.current_m_s:.2f} m/s"
    if entry.model.cameras and scene.sight_m < SIGHT_M:
        yield f"{name}'s cameras see {scene.sight_m:.1f} m in this water (optics.jerlov: {sim.optics.jerlov})"
    if entry.model.sonar is not None:
        range_m = multibeam_model(entry.sonar.loaded, entry.sonar.frequency_hz).range_max_m
        if -scene.bed.lowest_m - max(-vehicle.position_m[2], 0.0) > range_m:
            deep = f"the bed, which is at z = {scene.bed.lowest_m:.0f} m"
            yield f"{name}'s sonar reaches {range_m:g} m, from its start not everywhere down to {deep}"


def _of_trim(vehicle: VehicleScene) -> Iterator[str]:
    net_n, weight_n = vehicle.net_buoyancy_n, vehicle.weight_n
    down_n, up_n = vehicle.lift_n
    if vehicle.figures.metacentric_m is not None:
        return
    trim = "`trim: {net_buoyancy_n: 0}` in its entry would balance it in this water"
    if (net_n < 0.0 and -net_n > up_n > 0.0) or (net_n > 0.0 and net_n > -down_n > 0.0):
        what = "sinks" if net_n < 0 else "rises"
        yield f"vehicle '{vehicle.name}' {what}: {abs(net_n):.1f} N are more than its thrusters can lift; {trim}"
    elif not -TRIM_SHARE * weight_n <= net_n <= RISING_SHARE * weight_n:
        what = "sinks" if net_n < 0 else "rises"
        yield f"vehicle '{vehicle.name}' {what} by {abs(net_n):.1f} N where nobody holds it; {trim}"


def _near_each_other(scene: Scene) -> Iterator[tuple[int, str]]:
    for index, one in enumerate(scene.vehicles):
        for other in scene.vehicles[:index]:
            apart_m = float(np.linalg.norm(np.subtract(one.position_m, other.position_m)))
            if apart_m < one.radius_m + other.radius_m:
                yield index, f"vehicle '{one.name}' starts {apart_m:.2f} m from '{other.name}': their hulls may touch"


def _of_bed(scene: Scene) -> Iterator[str]:
    west, south, east, north = scene.bed.extent_m
    relief_m, longest_m = scene.bed.highest_m - scene.bed.lowest_m, max(east - west, north - south)
    if relief_m > longest_m:
        yield f"its heights differ by {relief_m:.0f} m over {longest_m:.0f} m: are they in metres? see vertical_scale"


def _of_station(scene: Scene) -> Iterator[str]:
    if np.isnan(scene.station_bed_m):
        yield "the station is beside the terrain"
    elif scene.station_bed_m >= 0.0 and any(vehicle.docked for vehicle in scene.vehicles):
        yield f"the station stands on land, {scene.station_bed_m:.1f} m high"


def _of_survey(sim: Simulator) -> Iterator[str]:
    survey, entry = sim.scenario.survey, sim.scenario.vehicles[0]
    if survey is None or entry.model.sonar is None:
        return
    fan = multibeam_model(entry.sonar.loaded, entry.sonar.frequency_hz)
    range_m = fan.range_max_m
    slant_m = survey.altitude_m / np.cos(np.radians(90.0 - min(max(survey.tilt_deg, 1.0), 89.0)))
    if slant_m > range_m:
        yield (
            f"survey: at {survey.altitude_m:g} m above the bed, tilted by {survey.tilt_deg:g} deg, the sonar would "
            f"have to reach {slant_m:.0f} m; it reaches {range_m:g} m"
        )
    ahead_m = recognised_ahead_m(survey.altitude_m, np.radians(survey.tilt_deg), 0.5 * fan.field_of_view_rad)
    if "sway" in sim.rov.controllable and ahead_m < STOP_S * survey.speed_m_s:
        yield (
            f"survey: at {survey.altitude_m:g} m above the bed, tilted by {survey.tilt_deg:g} deg, the sonar sees what "
            f"is ahead {ahead_m:.1f} m before it; at {survey.speed_m_s:g} m/s the vehicle needs "
            f"{STOP_S * survey.speed_m_s:.1f} m to stop"
        )
    corners = np.asarray(survey.area_m)
    deepest_m = _deepest_m(sim, corners)
    if survey.altitude_m > deepest_m + HIGHEST_Z_M:
        yield (
            f"survey: the water in its area is at most {deepest_m:.1f} m deep: the vehicle, which stays "
            f"{-HIGHEST_Z_M:g} m below the surface, cannot fly {survey.altitude_m:g} m above the bed"
        )
    x, y = corners.T
    area_m2 = abs(float(x @ np.roll(y, -1) - y @ np.roll(x, -1))) / 2.0
    needed_s = area_m2 / survey.line_spacing_m / survey.speed_m_s
    if needed_s > sim.scenario.mission_time_s:
        yield (
            f"survey: its lanes alone take some {needed_s:.0f} s, the battery (mission_time_s) lasts "
            f"{sim.scenario.mission_time_s:g} s"
        )


def _deepest_m(sim: Simulator, corners_m: Floats) -> float:
    """Return the largest depth of the bed on a grid over the bounding box of a survey's area."""
    axes = [np.linspace(low, high, 41) for low, high in zip(corners_m.min(axis=0), corners_m.max(axis=0), strict=True)]
    beds_m = sim.world.height_at(np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2))
    return -float(np.nanmin(beds_m)) if np.isfinite(beds_m).any() else 0.0
