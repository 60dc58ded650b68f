"""Draws tapes in the style of aircraft instruments, with heading along the top and depth down the side."""

from __future__ import annotations

import math

from rich.text import Text

POINTS = {0: "N", 45: "NE", 90: "E", 135: "SE", 180: "S", 225: "SW", 270: "W", 315: "NW"}
DEG_PER_CELL = 3.0
M_PER_LINE = 0.5
UNKNOWN = "---"


def heading_tape(heading_deg: float, width: int) -> Text:
    """Return two lines, with marks every 15 degrees that move past a fixed pointer, and the heading as a number."""
    if not math.isfinite(heading_deg):
        return Text("heading unknown".center(width), "dim")
    cells = [" "] * width
    middle = width // 2
    for mark in range(-360, 735, 15):
        at = middle + round((mark - heading_deg) / DEG_PER_CELL)
        label = POINTS.get(mark % 360) or (f"{mark % 360:03d}" if mark % 30 == 0 else "|")
        start = at - len(label) // 2
        if start >= 0 and start + len(label) <= width and all(c == " " for c in cells[start : start + len(label)]):
            cells[start : start + len(label)] = label
    tape = Text("".join(cells), "cyan", no_wrap=True)
    tape.append("\n" + f"▲ {round(heading_deg) % 360:03d}°".center(width), "bold white")
    return tape


def depth_tape(depth_m: float, seabed_m: float, height: int) -> Text:
    """Return `height` lines of 12 characters with a depth scale that moves past a pointer, surface and bed."""
    if not math.isfinite(depth_m):
        return Text("depth unknown", "dim")
    lines = Text(no_wrap=True)
    middle = height // 2
    top = round(depth_m / M_PER_LINE) - middle
    bed_m = depth_m + seabed_m
    for line in range(height):
        level_m = (top + line) * M_PER_LINE
        if line == middle:
            text, style = f"▶{depth_m:6.1f} m ", "bold white"
        elif level_m < 0.0:
            text, style = "            ", ""
        elif math.isfinite(bed_m) and level_m >= bed_m:
            text, style = "▒▒▒▒▒▒▒▒▒▒▒▒", "yellow"
        elif level_m == 0.0:
            text, style = "~~~~~~~~~~~~", "bold blue"
        elif level_m % 2.0 == 0.0:
            text, style = f"─{level_m:6.0f}     ", "cyan"
        else:
            text, style = "╴           ", "cyan"
        lines.append(f"{text:<12}", style)
        lines.append("\n")
    lines.right_crop()
    return lines
