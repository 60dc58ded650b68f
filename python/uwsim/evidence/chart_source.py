"""Charts and other rasters of elevations, as a source of scenarios."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.evidence.scenario_source import Made, ScenarioSource

SUFFIXES = (".bag", ".tif", ".tiff", ".h5", ".nc", ".grd", ".asc", ".img", ".vrt")
SIZE_M = 500.0


def _accepts(path: Path) -> bool:
    return path.is_file() and path.suffix.lower() in SUFFIXES


def _make(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    from uwsim.scenario.from_chart import scenario_from_chart

    made = scenario_from_chart(
        path,
        out or Path(path.stem.lower().replace(" ", "_") + ".yaml"),
        size_m=options.get("size", SIZE_M),
        centre=options.get("centre"),
        water_level_m=options.get("water_level", 0.0),
        unit=options.get("unit"),
        nodata=options.get("nodata"),
    )
    size, (high, low) = f"{made.size_m:g} x {made.size_m:g} m", made.depth_m
    return Made(made.path, [f"{size}, {high:.1f} to {low:.1f} m deep; uwsim survey {made.path}"])


OPTIONS = ("size", "centre", "water_level", "unit", "nodata")
CHART = ScenarioSource(f"a chart ({', '.join(SUFFIXES)})", _accepts, _make, OPTIONS)
