"""Draws a top view of a scenario for the start screen: depths, obstacles, survey area, station and vehicles."""

from __future__ import annotations

import io
import math
from functools import cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from uwsim.operator.station.scene.scene import thinned
from uwsim.scenario import Scenario, load
from uwsim.scenario.build.loose_bodies import object_start
from uwsim.scenario.build.solids import obstacle_solid
from uwsim.scenario.build.station import dock_position, station_at_start
from uwsim.scenario.build.terrain import Terrain, build_terrain

WIDTH, HEIGHT_MAX = 720, 480  # pixels
SHALLOW, DEEP, LAND = (159, 208, 214), (14, 44, 66), (150, 143, 116)
OBSTACLE, AREA, STATION, START, INK = (255, 176, 84), (255, 255, 255), (240, 96, 72), (255, 236, 120), (8, 20, 28)
TEXT = 20
Points = NDArray[np.float64]


@cache
def preview_png(name: str) -> bytes:
    """Return the top view of a named scenario as PNG. The result is cached. Raises ScenarioError or OSError."""
    return draw(load(name))


def draw(scenario: Scenario) -> bytes:
    """Return the top view of a scenario as PNG, north up."""
    full = build_terrain(scenario.terrain)
    plan = Plan(thinned(full))
    for obstacle in scenario.obstacles:
        vertices, triangles, _ = obstacle_solid(obstacle, full)
        plan.solid(np.asarray(vertices), np.asarray(triangles))
    for body in scenario.objects:
        plan.solid(*object_start(body, full))
    if scenario.survey is not None:
        plan.area(np.asarray(scenario.survey.area_m, float))
    station = station_at_start(scenario)
    plan.station(np.asarray(station.position_m))
    for entry in scenario.vehicles:
        if entry.start is None:
            plan.vehicle(dock_position(station), station.yaw_deg, ahead=20.0)  # clear of the station's mark
        else:
            plan.vehicle(np.asarray(entry.start.position_m), entry.start.yaw_deg)
    plan.scale()
    return plan.png()


class Plan:
    """A picture of a terrain on which items are drawn in world coordinates."""

    def __init__(self, terrain: Terrain) -> None:
        rows, columns = terrain.heights_m.shape
        self._low_m = np.asarray(terrain.origin_m, float)[:2]
        size_m = np.array([columns - 1, rows - 1]) * terrain.spacing_m
        self._pixels_per_m = min(WIDTH / size_m[0], HEIGHT_MAX / size_m[1])
        width, height = (max(1, round(edge * self._pixels_per_m)) for edge in size_m)
        colours = Image.fromarray(shaded(terrain)[::-1])
        self._image = colours.resize((width, height), Image.Resampling.BICUBIC)
        self._pen = ImageDraw.Draw(self._image)
        self._deepest_m = -float(np.nanmin(terrain.heights_m))

    def solid(self, vertices: Points, triangles: NDArray[np.integer]) -> None:
        """Draw the outline of a solid as seen from above."""
        corners = self._at(vertices)[triangles]
        for triangle in corners:
            self._pen.polygon([tuple(corner) for corner in triangle], fill=OBSTACLE, outline=OBSTACLE)

    def area(self, polygon_m: Points) -> None:
        """Draw the outline of the survey area."""
        outline = [tuple(corner) for corner in self._at(polygon_m)]
        self._pen.line([*outline, outline[0]], fill=AREA, width=2)

    def station(self, position_m: Points) -> None:
        """Mark the station."""
        x, y = self._at(position_m)
        self._pen.rectangle((x - 8, y - 8, x + 8, y + 8), fill=STATION, outline=INK, width=2)

    def vehicle(self, position_m: Points, yaw_deg: float, ahead: float = 0.0) -> None:
        """Mark a vehicle's starting position with an arrow along its heading. ahead: offset of the arrow in pixels."""
        along = np.array([math.cos(math.radians(yaw_deg)), -math.sin(math.radians(yaw_deg))])
        across = np.array([-along[1], along[0]])
        middle = self._at(position_m) + ahead * along
        corners = (middle + 13.0 * along, middle - 8.0 * along + 8.0 * across, middle - 8.0 * along - 8.0 * across)
        self._pen.polygon([tuple(corner) for corner in corners], fill=START, outline=INK)

    def scale(self) -> None:
        """Draw a scale bar with its length, and an arrow down with the maximum depth."""
        most_m = 0.25 * self._image.width / self._pixels_per_m
        power = 10.0 ** math.floor(math.log10(most_m))
        length_m = max(step * power for step in (1, 2, 5) if step * power <= most_m)
        right, low = self._image.width - 14, self._image.height - 14
        left = right - length_m * self._pixels_per_m
        self._pen.line((left, low, right, low), fill=AREA, width=3)
        self._text((left + right) / 2.0, low - 6, f"{length_m:g} m", "ms")
        self._pen.line((18, low - 14, 18, low - 4), fill=AREA, width=3)
        self._pen.polygon([(12, low - 7), (24, low - 7), (18, low)], fill=AREA)
        self._text(32, low, f"{self._deepest_m:.0f} m", "ls")

    def png(self) -> bytes:
        """Return the picture as PNG."""
        data = io.BytesIO()
        self._image.save(data, "PNG")
        return data.getvalue()

    def _text(self, x: float, y: float, text: str, anchor: str) -> None:
        font = ImageFont.load_default(TEXT)
        self._pen.text((x, y), text, fill=AREA, font=font, anchor=anchor, stroke_width=2, stroke_fill=INK)

    def _at(self, points_m: Points) -> Points:
        """Return the pixel coordinates (..., 2) of world points (..., 2 or 3)."""
        pixels: Points = (points_m[..., :2] - self._low_m) * self._pixels_per_m
        pixels[..., 1] = self._image.height - pixels[..., 1]
        return pixels


def shaded(terrain: Terrain) -> NDArray[np.uint8]:
    """Return the colours (rows, columns, 3) of a terrain by depth, lit from the north-west, southernmost row first."""
    heights = np.nan_to_num(np.asarray(terrain.heights_m, float), nan=float(np.nanmin(terrain.heights_m)))
    depth = np.clip(heights / min(float(heights.min()), -1e-3), 0.0, 1.0)[..., None]
    colours = (1.0 - depth) * SHALLOW + depth * np.asarray(DEEP, float)
    colours[heights > 0.0] = LAND
    north, east = np.gradient(heights, terrain.spacing_m)
    light = (1.0 + east - north) / np.sqrt(3.0 * (1.0 + east**2 + north**2))  # from 45 degrees up; flat ground: 0.58
    lit = colours * (0.55 + 0.78 * np.clip(light, 0.0, 1.0))[..., None]
    return np.asarray(np.clip(lit, 0, 255), np.uint8)
