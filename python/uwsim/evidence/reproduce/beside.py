"""The paper's figures from its authors' own files beside ours, with a number for each, in a folder to deposit."""

from __future__ import annotations

import csv
import io
import shutil
import tempfile
import time
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image, ImageDraw, ImageFont

from uwsim.base.atomic_file import unfinished, write_atomically
from uwsim.evidence.reproduce import graphs, movement_and_ray, sonar
from uwsim.evidence.reproduce.deposit import write_deposit
from uwsim.evidence.reproduce.figure import Figure
from uwsim.evidence.reproduce.number import Number, shown
from uwsim.evidence.reproduce.paper import Subject, draw
from uwsim.evidence.reproduce.their_world import TheirWorld, hull_m, their_world
from uwsim.figures.truth_and_map import draw_truth_and_map, render_truth_and_map
from uwsim.flight.survey import run_survey
from uwsim.flight.terminal import Silent
from uwsim.instruments.cameras.image_file import write_image
from uwsim.scenario import load
from uwsim.simulator.simulator import Simulator

SIDES = ("theirs", "ours")
HEADS = {"theirs": "from the paper's own files", "ours": "from the packaged scenario `paper`"}
WIDTH, HEAD, GAP = 960, 66, 12
NEAR_M, BEAM_M, BED_SHARE, VOXELS = 1.0, 0.1, 0.9, 1.0


def reproduce_beside(
    checkout: Path,
    out: Path,
    options: Mapping[str, Any],
    command: str,
    progress: Callable[[str], object] = lambda text: None,
) -> list[Number]:
    """Draw all figures from a checkout of the paper's project beside ours, into a folder that is new or empty.

    options: of the conversion, `scene` and `terrain`. The folder appears once it is complete. Raises ValueError or
    OSError.
    """
    if out.is_dir() and any(out.iterdir()):
        raise FileExistsError(f"--out {out}: the folder is not empty: name a new one, since a deposit is one whole")
    if out.exists() and not out.is_dir():
        raise FileExistsError(f"--out {out}: is not a folder")
    out.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix=f".{out.name}.", dir=out.parent) as work, unfinished(Path(work)):
        folder = Path(work) / "deposit"
        numbers = _make(checkout, folder, options, command, progress)
        folder.replace(out)
    return numbers


def _make(
    checkout: Path, folder: Path, options: Mapping[str, Any], command: str, progress: Callable[[str], object]
) -> list[Number]:
    began_s = time.monotonic()

    def report(what: str) -> None:
        progress(f"{what}  ({time.monotonic() - began_s:.0f} s)")

    report("reading their project")
    theirs = their_world(checkout, folder / "scenario", options)
    for note in theirs.notes:
        progress(f"  {note}")
    subjects = {"theirs": theirs.subject, "ours": Subject(load("paper"))}
    drawn: dict[str, dict[int, Figure]] = {}
    for side, subject in subjects.items():
        (folder / side).mkdir()
        drawn[side] = {}

        def add(figure: Figure, side: str = side) -> None:
            drawn[side][figure.number] = figure
            report(f"{side}/{figure.name}.png  {figure.title}")

        draw(subject, folder / side, add)
        add(_survey_map(subject, folder / side))
    table = sonar.coverage(folder / "ours/fig08.png")
    shutil.copyfile(folder / "ours/fig08.png", folder / "theirs/fig08.png")
    for side in SIDES:
        drawn[side][8] = table
    report("fig08.png  " + table.title)
    numbers = _numbers(theirs, subjects, drawn)
    for figure in drawn["ours"]:
        name = f"fig{figure:02d}.png"
        pictures = {side: Image.open(folder / side / name).convert("RGB") for side in SIDES}
        own = [number for number in numbers if number.figure == figure]
        write_image(folder / name, side_by_side(pictures, own), optimize=True)
    write_atomically(folder / "numbers.csv", _csv(numbers))
    write_deposit(folder, checkout, command, theirs, numbers, drawn)
    report("README.md, manifest.json, numbers.csv")
    return numbers


def _survey_map(subject: Subject, folder: Path) -> Figure:
    """Draw Fig. 12 of a world's survey, flown by its vehicle's plan rather than by walls, which their bed may lack."""
    with tempfile.TemporaryDirectory() as work:
        record = run_survey(subject.scenario, work, report="json", screen=Silent())
        shutil.copyfile(Path(work) / "map.bt", folder / "map.bt")
    sim, score, occupancy = Simulator(subject.scenario), record.score, record.occupancy
    assert score is not None and occupancy is not None  # a survey builds and scores a map
    voxel_m, occupied_m, area_m = occupancy.resolution_m, occupancy.occupied_voxels(), np.asarray(record.area_world_m)
    track_m = record.true_pings_world_m[sim.rov.name]
    rendered = render_truth_and_map(sim.world, sim.scene, area_m, occupied_m, voxel_m)
    draw_truth_and_map(folder / "fig12.png", rendered, track_m)
    return Figure(
        12, "The terrain and the 3D occupancy map", "The true terrain beside the map of the scenario's survey.",
        "Theirs is flown by lawn_mower.py, which turns at walls.",
        {"bed_mapped_percent": 100.0 * score.coverage, "map_error_mean_m": score.distance_mean_m, "voxel_m": voxel_m,
         "pings": len(track_m), "simulated_s": record.simulated_s},
    )  # fmt: skip


def _numbers(
    theirs: TheirWorld, subjects: Mapping[str, Subject], drawn: Mapping[str, Mapping[int, Figure]]
) -> list[Number]:
    """Return the number of each figure, in order."""
    ours = drawn["ours"]
    length = {side: float(np.ptp(hull_m(Simulator(each.scenario)), axis=0)[0]) for side, each in subjects.items()}
    red = {side: drawn[side][2].values["red_left"] for side in SIDES}
    panel = {side: dict(drawn[side][5].rows) for side in SIDES}
    depth = {side: drawn[side][6].values["mean_m"] for side in SIDES}
    hits = {side: [row[2] for row in drawn[side][7].rows if row[1].startswith("gate")] for side in SIDES}
    bar_m = {side: float(each[0]) if each else None for side, each in hits.items()}
    echoes = {side: drawn[side][9].values["echoes"] / drawn[side][9].values["beams"] for side in SIDES}
    trees = {side: [tuple(row[1:3]) for row in drawn[side][10].rows if row[0] == "published"] for side in SIDES}
    frames = {side: {row[2] for row in drawn[side][10].rows if row[0] == "standard"} for side in SIDES}
    kept = {side: sum(set(link) <= frames[side] for link in trees[side]) for side in SIDES}
    made = {topic for _, topic in graphs.NODES.values()} - {"key"}
    used = {topic for topics, _ in graphs.NODES.values() for topic in topics} - made | {"key"}
    edges = {side: len(used & {row[1] for row in drawn[side][11].rows if "simulator" in row}) for side in SIDES}
    bed, error = ({side: drawn[side][12].values[key] for side in SIDES} for key in
                  ("bed_mapped_percent", "map_error_mean_m"))  # fmt: skip
    voxel_m = ours[12].values["voxel_m"]
    away_m, time_s = max(theirs.missing_m.values()), subjects["ours"].scenario.mission_time_s
    radii = (
        theirs.gates[movement_and_ray.TARGET],
        movement_and_ray.gate_of(Simulator(subjects["ours"].scenario), movement_and_ray.TARGET),
    )
    cells = len(ours[8].rows)
    close = sum(abs(row[-1]) <= 10.0 for row in ours[8].rows)
    warned = {side: bool(panel[side]["proximity warning"]) for side in SIDES}
    return [
        Number(1, "largest distance of a gate of ours from theirs", "m", 0.0, away_m, f"at most {NEAR_M:g} m",
               away_m <= NEAR_M),
        Number(2, "red relative to green that the water leaves in the picture", "", red["theirs"], red["ours"],
               "less than 1 in both", max(red.values()) < 1.0),
        Number(3, "length of the hull", "m", length["theirs"], length["ours"], "within 10 %",
               abs(length["ours"] / length["theirs"] - 1.0) <= 0.1),
        Number(4, "mission time that the start screen offers", "s", theirs.mission_time_s, time_s, "equal",
               theirs.mission_time_s == time_s),
        Number(5, "distance to the seabed at which the proximity warning is lit", "m",
               float(panel["theirs"]["distance to seabed [m]"]), float(panel["ours"]["distance to seabed [m]"]),
               "lit in both", all(warned.values())),
        Number(6, "mean difference of a depth map's ranges from rays", "m", depth["theirs"], depth["ours"],
               f"less than {BEAM_M:g} m in both", max(depth.values()) < BEAM_M),
        Number(7, "range of the ray to the gate's bar", "m", bar_m["theirs"], bar_m["ours"],
               "one of five rays hits in both", all(len(each) == 1 for each in hits.values())),
        Number(7, "radius of the gate", "m", radii[0].radius_m, radii[1].radius_m, "within 10 %",
               abs(radii[1].radius_m / radii[0].radius_m - 1.0) <= 0.1),
        Number(8, "cells of the EM 2040's table within 10 %", f"of {cells}", cells, close, "all", close == cells),
        Number(9, "share of beams with an echo", "", echoes["theirs"], echoes["ours"], "more than half in both",
               min(echoes.values()) > 0.5),
        Number(10, "transforms of the published tree whose frames the standard one has", f"of {len(trees['ours'])}",
               kept["theirs"], kept["ours"], "all in both", all(kept[side] == len(trees[side]) for side in SIDES)),
        Number(11, "topics that the published nodes exchange with the simulator", f"of {len(used)}", edges["theirs"],
               edges["ours"], "all in both", min(edges.values()) == len(used)),
        Number(12, "bed covered by the survey's map", "%", bed["theirs"], bed["ours"],
               f"at least {100.0 * BED_SHARE:g} % in both", min(bed.values()) >= 100.0 * BED_SHARE),
        Number(12, "mean error of the map", "m", error["theirs"], error["ours"],
               f"at most a voxel, {voxel_m:g} m, in both", max(error.values()) <= VOXELS * voxel_m),
    ]  # fmt: skip


def side_by_side(pictures: Mapping[str, Image.Image], numbers: Sequence[Number]) -> Any:
    """Return two pictures (h, w, 3) uint8 beside each other, below the names of their sources and their numbers."""
    scaled = {
        side: each.resize((WIDTH, max(1, round(each.height * WIDTH / each.width)))) for side, each in pictures.items()
    }
    height = HEAD + max(each.height for each in scaled.values())
    sheet = Image.new("RGB", (2 * WIDTH + GAP, height), "white")
    pen, font, small = ImageDraw.Draw(sheet), ImageFont.load_default(22), ImageFont.load_default(17)
    for k, (side, each) in enumerate(scaled.items()):
        left = k * (WIDTH + GAP)
        sheet.paste(each, (left, HEAD))
        values = "; ".join(f"{one.quantity}: {shown(getattr(one, side), one.unit)}" for one in numbers)
        pen.text((left + 8, 6), HEADS[side], "black", font)
        pen.text((left + 8, 36), values, "black", small)
    return np.asarray(sheet)


def _csv(numbers: list[Number]) -> bytes:
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(["figure", "quantity", "unit", "theirs", "ours", "claim", "held"])
    for each in numbers:
        rows.writerow([each.figure, each.quantity, each.unit, each.theirs, each.ours, each.claim, each.held])
    return text.getvalue().encode()
