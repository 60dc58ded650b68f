"""The published simulator's Unity project, as a source of scenarios."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from uwsim.exchange.scenario_source import Made, ScenarioSource

SCENE, TERRAIN = "LawnTest", "SolidTerrain"


def _accepts(path: Path) -> bool:
    return (path / "Assets").is_dir()


def _make(path: Path, out: Path | None, options: Mapping[str, Any]) -> Made:
    from uwsim.exchange.unity.project import Project
    from uwsim.exchange.unity.scenario import scenario_from

    scene = options.get("scene", SCENE)
    scenes = sorted(file for file in (path / "Assets").rglob("*.unity"))
    found = [file for file in scenes if file.stem == scene]
    if not found:
        names = ", ".join(file.stem for file in scenes)
        raise ValueError(f"--scene = {scene!r}: must be one of {names}" if scenes else f"'{path}': has no scenes")
    folder = out or Path(scene.lower().replace(" ", "_"))
    return scenario_from(
        Project(path),
        found[0],
        folder,
        terrain=options.get("terrain", TERRAIN),
        size_m=options.get("size"),
        centre_m=options.get("centre", (0.0, 0.0)),
    )


OPTIONS = ("scene", "terrain", "size", "centre")
UNITY = ScenarioSource("the checkout of a Unity project, with a folder Assets", _accepts, _make, OPTIONS)
