"""The world in the paper's own files: a scenario from a checkout of its Unity project, equipped as `paper` is."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.arrays import Floats
from uwsim.base.atomic_file import write_atomically
from uwsim.base.texts.yaml_document import read_yaml
from uwsim.evidence.reproduce.movement_and_ray import AWAY_M, Gate, gate_of
from uwsim.evidence.reproduce.paper import Subject
from uwsim.evidence.reproduce.scenes import Place
from uwsim.evidence.reproduce.screens import OVER_THE_PIPELINE
from uwsim.exchange.unity.scenario import TERRAIN, UNITY
from uwsim.scenario import load
from uwsim.scenario.build.hull import hull_box_m, vehicle_hull
from uwsim.scenario.dump import yaml_text
from uwsim.scenario.read.assets import find_yaml
from uwsim.scenario.read.note import Note
from uwsim.simulator.simulator import Simulator

EQUIPPED = "equipped.yaml"
CLEAR_M = 0.1
"""From a camera or lamp to the box about the hull, so that no part of it is in view."""
SHOWN_GATES = "gate_3", "gate_1"
"""Names in `paper`: the gate of Figs. 2 and 6, and that of Fig. 7."""
ABOVE_BED_M = 6.5
"""Height of Fig. 5's place above the bed, as in `paper`."""
START_SCREEN = "Assets/Scripts/StartScreen.cs"
BATTERY = re.compile(r"batteryTime\s*=\s*([0-9.]+)f\s*;")
INPUTS = (".unity", ".prefab", ".fbx", ".mat", ".cs")
"""Kinds of files in Assets on which the figures depend."""


@dataclass(frozen=True, eq=False)
class TheirWorld:
    """A converted project. notes: what was left out or assumed. gates: theirs, by the name of the nearest of `paper`.

    missing_m: how far each is from that one. mission_time_s: the default of their start screen, None if it has none.
    bed: the name of the object that is the bed.
    """

    subject: Subject
    notes: list[Note]
    gates: dict[str, Gate]
    missing_m: dict[str, float]
    mission_time_s: float | None
    seed: int
    bed: str

    @property
    def missing_bed(self) -> list[str]:
        """The parts of the bed whose files the checkout lacks, and which."""
        left_out = (note.text for note in self.notes if note.kind == "left out")
        return [text for text in left_out if text.startswith(f"{self.bed}/") and text.endswith("missing")]


def their_world(checkout: Path, folder: Path, options: Mapping[str, Any]) -> TheirWorld:
    """Convert the project in `checkout` into a folder. options: `scene` and `terrain`. Raises ValueError or OSError."""
    if not checkout.exists():
        raise FileNotFoundError(f"--from '{checkout}': there is no such folder")
    if not UNITY.accepts(checkout, b""):
        raise ValueError(f"--from '{checkout}': must be {UNITY.what}")
    made = UNITY.read(checkout, folder, options)
    _equip(made.path)
    scenario = load(made.path)
    sim, ours = Simulator(scenario), Simulator("paper")
    theirs = [gate_of(sim, item.name) for item in scenario.obstacles if item.name.startswith("gate")]
    if not theirs:
        raise ValueError(f"'{checkout}': the scene has no object whose name begins with Gate: --scene names another")
    gates, away_m = {}, {}
    for item in ours.scenario.obstacles:
        if item.name.startswith("gate"):
            middle = gate_of(ours, item.name).middle_m
            gates[item.name] = min(theirs, key=lambda gate: float(np.linalg.norm(gate.middle_m - middle)))
            away_m[item.name] = float(np.linalg.norm(gates[item.name].middle_m - middle))
    size = _length_m(sim) / _length_m(ours)
    seen, hit = (gates[name] for name in SHOWN_GATES)
    bed = options.get("terrain", TERRAIN)
    subject = Subject(scenario, str(made.path), _before(seen), _over_the_bed(sim), hit.name, size)
    return TheirWorld(subject, made.notes, gates, away_m, _mission_time_s(checkout), scenario.seed, bed)


def inputs(checkout: Path) -> list[Path]:
    """Return the project's files on which the figures depend, in order."""
    return [path for path in sorted((checkout / "Assets").rglob("*"))
            if path.suffix.lower() in INPUTS and path.is_file() and not path.is_symlink()]  # fmt: skip


def _equip(path: Path) -> None:
    """Give the drafted vehicle the cameras, lamps and instruments of `paper`, outside its own, larger hull."""
    values = read_yaml(path).values
    drafted = read_yaml(path.parent / values["vehicles"][0]["model"]).values
    paper = read_yaml(find_yaml("paper", "vehicles")).values
    low, high = hull_box_m(load(path).vehicles[0].model)
    bow, keel = float(high[0]) + CLEAR_M, float(low[2]) - CLEAR_M
    ahead, under = [round(bow, 3), 0.0, 0.0], [0.0, 0.0, round(keel, 3)]
    cameras, lamps = paper["cameras"], paper["lamps"]
    cameras["front"]["position_m"], cameras["down"]["position_m"] = ahead, under
    for name, place in (("front", ahead), ("down", under)):
        for k, spot in enumerate(lamps[name]["spots"]):
            spot["position_m"] = [place[0], 0.36 - 0.72 * k, place[2]]
    sensors = {name: each for name, each in paper["sensors"].items() if name not in drafted["sensors"]}
    sensors["proximity_port"]["position_m"] = [0.0, round(float(high[1]) + CLEAR_M, 3), 0.0]
    drafted |= {"cameras": cameras, "lamps": lamps, "sensors": {**drafted["sensors"], **sensors}}
    write_atomically(path.parent / EQUIPPED, yaml_text(drafted).encode())
    values["vehicles"][0]["model"] = EQUIPPED
    write_atomically(path, yaml_text(values).encode())


def _before(gate: Gate) -> Place:
    x, y, z = (gate.middle_m - AWAY_M * gate.ahead).tolist()
    return (x, y, z), math.degrees(math.atan2(gate.ahead[1], gate.ahead[0]))


def _over_the_bed(sim: Simulator) -> Place:
    """Return the place of `paper`, at the same height above their bed, or the vehicle's start if it is too shallow."""
    (x, y, _), yaw_deg = OVER_THE_PIPELINE
    bed_m = float(sim.world.height_at(np.array([[x, y]]))[0])
    if math.isfinite(bed_m) and bed_m < -2.0 * ABOVE_BED_M:
        return (x, y, bed_m + ABOVE_BED_M), yaw_deg
    east, north, up = sim.rov.pose.position_world_m.tolist()
    return (east, north, up), yaw_deg


def _length_m(sim: Simulator) -> float:
    return float(np.ptp(hull_m(sim), axis=0).max())


def hull_m(sim: Simulator) -> Floats:
    """Return the points (n, 3) of the first vehicle's hull, body frame."""
    return vehicle_hull(sim.scenario.vehicles[0].model)[0]


def _mission_time_s(checkout: Path) -> float | None:
    """Return 100 % over the battery's default loss per second, as their start screen states it."""
    path = checkout / START_SCREEN
    found = BATTERY.search(path.read_text(errors="replace")) if path.is_file() else None
    return None if found is None else 100.0 / float(found[1])
