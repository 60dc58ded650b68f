"""Formats the report on a check as lines for a terminal."""

from __future__ import annotations

import math
from collections.abc import Iterator

from uwsim.evidence.scenario_check.report import CheckReport
from uwsim.evidence.scenario_check.scene import ObstacleScene, Scene, VehicleScene
from uwsim.evidence.vehicle.text import vehicle_lines
from uwsim.scenario.build.craft import floating_text


def report_lines(report: CheckReport) -> list[str]:
    """Return the lines for a file without mistakes: the number of warnings and a description of the contents."""
    count = len(report.warnings)
    lines = [f"{report.file}: ok" + (f", {count} warning{'s' if count > 1 else ''}" if count else "")]
    details = [*_scene_lines(report.scene)] if report.scene else []
    if report.vehicle is not None:
        details += vehicle_lines(report.vehicle)
    return lines + [f"  {line}" for line in details]


def _scene_lines(scene: Scene) -> Iterator[str]:
    west, south, east, north = scene.bed.extent_m
    dry = f", {100 * scene.bed.dry_share:.0f} % of it above the water" if scene.bed.dry_share > 0 else ""
    yield (
        f"terrain: x {west:g} to {east:g} m, y {south:g} to {north:g} m, "
        f"bed from z = {scene.bed.lowest_m:.1f} to {scene.bed.highest_m:.1f} m{dry}"
    )
    yield f"water: {scene.density_kg_m3:.4g} kg/m3 at the surface; cameras see some {scene.sight_m:.2g} m"
    x, y, _ = scene.station_m
    over = "beside the terrain" if math.isnan(scene.station_bed_m) else f"over {-scene.station_bed_m:.1f} m of water"
    yield f"station: ({x:g}, {y:g}) m, {over}"
    for vehicle in scene.vehicles:
        yield _vehicle_line(vehicle)
        yield from (f"  {line}" for line in vehicle_lines(vehicle.figures))
    for obstacle in scene.obstacles:
        yield _obstacle_line(obstacle)


def _vehicle_line(vehicle: VehicleScene) -> str:
    x, y, z = vehicle.position_m
    place = "docked at" if vehicle.docked else "free at"
    return (
        f"vehicle '{vehicle.name}' ({vehicle.model}): {place} ({x:g}, {y:g}, {z:g}) m, yaw {vehicle.yaw_deg:g} deg, "
        f"{vehicle.altitude_m:.1f} m above the bed; {floating_text(vehicle.net_buoyancy_n)}"
    )


def _obstacle_line(obstacle: ObstacleScene) -> str:
    return (
        f"{obstacle.kind} '{obstacle.name}': z = {obstacle.lowest_m:.1f} to {obstacle.highest_m:.1f} m, "
        f"{100 * obstacle.buried_share:.0f} % of it below the bed"
    )
