"""Draws the sonar fan as dots: the vehicle is at the bottom centre, ahead is up, port is left."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from rich.text import Text

from uwsim.operator.teleop.braille import COLUMNS, ROWS, Canvas

SCALES_M = (5.0, 10.0, 20.0, 40.0, 60.0, 100.0)
RINGS = 4
NEAR = ("bold red", "bold yellow", "bold green", "bold cyan")  # by quarter of the scale
ARC = 400  # number of dots in a ring


def fan_scale_m(ranges_m: NDArray[np.float32]) -> float:
    """Return the smallest scale that shows 90 % of the echoes, or the largest scale if there are no echoes."""
    echoes = ranges_m[np.isfinite(ranges_m)]
    far_m = float(np.quantile(echoes, 0.9)) if len(echoes) else math.inf
    return next((scale_m for scale_m in SCALES_M if scale_m >= far_m), SCALES_M[-1])


def draw_fan(angles_rad: NDArray[np.float64], ranges_m: NDArray[np.float32], width: int, height: int) -> Text:
    """Return the fan as `width` x `height` characters. Ranges that are not finite are ignored."""
    if width < 8 or height < 4:
        return Text()
    if not len(ranges_m):
        return Text("no sonar", "dim")
    scale_m, half = fan_scale_m(ranges_m), max(float(np.abs(angles_rad).max()), 0.1)
    dots_across, dots_down = COLUMNS * width, ROWS * (height - 1)  # the last line shows the scale
    reach = min(dots_down - 1.0, (dots_across - 1) / 2 / math.sin(min(half, 0.5 * math.pi)))
    middle = (dots_across - 1) / 2
    canvas = Canvas(width, height - 1)

    def polar(angle_rad: NDArray[np.float64], share: NDArray[np.float64], style: str) -> None:
        canvas.dot(middle - reach * share * np.sin(angle_rad), dots_down - 1 - reach * share * np.cos(angle_rad), style)

    arc = np.linspace(-half, half, ARC)
    for ring in range(1, RINGS + 1):
        dots = arc[:: 8 if ring < RINGS else 4]
        polar(dots, np.full(len(dots), ring / RINGS), "blue")
    for edge in (-half, half):
        polar(np.full(ARC // 8, edge), np.linspace(0.0, 1.0, ARC // 8), "blue")
    share = np.asarray(ranges_m, np.float64) / scale_m
    heard = np.isfinite(share) & (share <= 1.0)
    quarters = np.minimum(np.floor(np.where(heard, share, 0.0) * RINGS), RINGS - 1)
    for quarter in reversed(range(RINGS)):
        chosen = heard & (quarters == quarter)
        polar(angles_rad[chosen], share[chosen], NEAR[quarter])
    caption = f"{scale_m:g} m, rings of {scale_m / RINGS:g} m"
    nearest_m = float(np.min(ranges_m[np.isfinite(ranges_m)], initial=math.inf))
    nearest = f", nearest {nearest_m:.1f} m" if math.isfinite(nearest_m) else ", no echo"
    picture = canvas.text()
    picture.append("\n")
    return picture.append((caption + nearest).center(width)[:width], "dim")
