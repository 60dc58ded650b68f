"""Deep, open, still water in which vehicles can move freely."""

from __future__ import annotations

from pathlib import Path

from uwsim import Simulator

SCENARIO = """
name: sea
mission_time_s: 1e5
water: {{density_kg_m3: {density_kg_m3}, surface_temperature_deg_c: 10, bottom_temperature_deg_c: 10}}
terrain: {{source: noise, size_m: [2000, 2000], spacing_m: 50, bed_depth_m: 100}}
station: {{position_m: [0, 0, 0]}}
vehicles:
"""


def open_water(folder: Path, *models: str, density_kg_m3: float = 1000.0, apart_m: float = 5.0) -> Simulator:
    """Create undocked vehicles of these models at rest, 30 m deep, heading east, spaced `apart_m` apart along y."""
    path = folder / "sea.yaml"
    text = SCENARIO.format(density_kg_m3=density_kg_m3)
    for k, model in enumerate(models):
        text += f"  - {{name: vehicle{k}, model: {model}, start: {{position_m: [0, {apart_m * k}, -30]}}}}\n"
    path.write_text(text)
    return Simulator(path)
