"""Charts and other rasters of elevations, as a source of scenarios."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.base.own_files import remove_own_file
from uwsim.exchange.scenario_source import Made, ScenarioSource

SUFFIXES = (".bag", ".tif", ".tiff", ".h5", ".nc", ".grd", ".asc", ".img", ".vrt")
SOUNDED = (".xyz", ".csv", ".txt", ".dat", ".las", ".laz")
SIZE_M = 500.0


def _named_after(path: Path) -> Path:
    return Path(path.stem.lower().replace(" ", "_") + ".yaml")


def _from_chart(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    from uwsim.exchange.from_chart import scenario_from_chart

    stated = {key: options[key] for key in STATED if key in options}
    made = scenario_from_chart(
        path, out or _named_after(path), size_m=options.get("size", SIZE_M), centre=options.get("centre"),
        water_level_m=options.get("water_level", 0.0), **stated,
    )  # fmt: skip
    size, (high, low) = f"{made.size_m:g} x {made.size_m:g} m", made.depth_m
    return Made(made.path, [f"{size}, {high:.1f} to {low:.1f} m deep; uwsim survey {made.path}", *made.notes])


def _from_soundings(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    """Grid soundings into a GeoTIFF beside the scenario, and make it from that."""
    from uwsim.exchange.soundings import grid_soundings, read_soundings

    out = out or _named_after(path)
    found = read_soundings(path)
    read = {key: value for key, value in options.items() if key not in ("cell", "crs")}
    if found.positive is not None:
        read.setdefault("positive", found.positive)
    chart = out.with_suffix(".tif")
    note = grid_soundings(found, chart, cell=options.get("cell"), crs=options.get("crs"))
    try:
        made = _from_chart(chart, out, read)
    except (ValueError, OSError):
        remove_own_file(chart)
        raise
    return Made(made.path, [*found.notes, note, *made.notes])


STATED = ("unit", "nodata", "positive", "crs")
OPTIONS = ("size", "centre", "water_level", *STATED)
CHART = ScenarioSource(
    f"a chart ({', '.join(SUFFIXES)})", lambda path: path.is_file() and path.suffix.lower() in SUFFIXES,
    _from_chart, OPTIONS,
)  # fmt: skip
SOUNDINGS = ScenarioSource(
    f"soundings as x y z ({', '.join(SOUNDED)})", lambda path: path.is_file() and path.suffix.lower() in SOUNDED,
    _from_soundings, (*OPTIONS, "cell"),
)  # fmt: skip
