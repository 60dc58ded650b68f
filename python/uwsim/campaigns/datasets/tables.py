"""Tables that cover all frames of a dataset: dataset.json, frames.jsonl, annotations."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from uwsim.base.atomic_file import write_atomically
from uwsim.campaigns.datasets.files import coco, yolo_yaml
from uwsim.campaigns.datasets.frame import file_name, folders
from uwsim.campaigns.datasets.spec import OF_CAMERA, DatasetSpec
from uwsim.campaigns.datasets.studio import Studio

ABOUT, FRAMES = "dataset.json", "frames.jsonl"
SPLITS = ("train", "val")
STRETCHES = 4
"""The number of stretches for validation, spread along a track."""
OF_TABLES = ("annotations", "sonar_annotations", "job", "trials")
"""Fields of a record that are left out of frames.jsonl."""
CONVENTIONS = {
    "world": "east, north, up; z = 0 at the water's surface; metres",
    "body": "x ahead, y to port, z up",
    "optical": "x right, y down, z ahead; the centres of pixels have whole coordinates",
    "depth": "millimetres along the optical axis; 0: nothing, or beyond 65.535 m",
    "normals": "in the optical frame, towards the camera: value = 127.5 (n + 1); 0, 0, 0: nothing",
    "instances": "value = index into label_names; 0 also beyond label_range_m",
    "classes": "value = index into class_names; 0 also beyond label_range_m",
    "sonar": "row 0 is the farthest range, column 0 port; black and white at sonar_limits_db; sonar_arrays have the "
    "nearest range first, and starboard",
}


def write_tables(
    out: Path, studio: Studio, plan: Mapping[str, Any], records: Sequence[Mapping[str, Any]], splits: Sequence[str]
) -> list[Path]:
    """Write the tables into `out`; return their paths. records: the records of all frames, in order. Raises OSError."""
    spec, written = studio.spec, []

    def write(name: str, content: str) -> None:
        (out / name).parent.mkdir(exist_ok=True)
        write_atomically(out / name, content.encode())
        written.append(out / name)

    lines = [_line(spec, record, split) for record, split in zip(records, splits, strict=True)]
    write(FRAMES, "".join(json.dumps(line) + "\n" for line in lines))
    about = _about(studio, plan, splits)
    if spec.writes("yolo"):
        write("data.yaml", yolo_yaml(studio.class_names))
    for split in SPLITS:
        if spec.writes("yolo"):
            write(f"{split}.txt", "".join(f"./{line['files']['rgb']}\n" for line in lines if line["split"] == split))
        of_split = [record for record, of in zip(records, splits, strict=True) if of == split]
        if spec.writes("boxes"):
            write(f"annotations/instances_{split}.json", _coco(studio, about, of_split, "rgb", "annotations"))
        if spec.writes("sonar"):
            write(f"annotations/sonar_{split}.json", _coco(studio, about, of_split, "sonar", "sonar_annotations"))
    write(ABOUT, _dumped(about))
    return written


def _line(spec: DatasetSpec, record: Mapping[str, Any], split: str) -> dict[str, Any]:
    kept = {key: value for key, value in record.items() if key not in OF_TABLES}
    files = {kind: file_name(spec, kind, record["frame"]) for kind in folders(spec)}
    return {**kept, "split": split, "files": files}


def _about(studio: Studio, plan: Mapping[str, Any], splits: Sequence[str]) -> dict[str, Any]:
    about: dict[str, Any] = {
        "uwsim": version("uwsim"),
        **plan,
        "scenario_name": studio.sim.scenario.name,
        "seed": studio.sim.seed,
        "vehicle": studio.vehicle.name,
        "frames": len(splits),
        "splits": {split: splits.count(split) for split in SPLITS},
        "folders": {kind: where.split("/")[0] for kind, where in folders(studio.spec).items()},
        "label_names": studio.label_names,
        "class_names": studio.class_names,
        "class_of_label": [int(number) for number in studio.class_of_label],
        "conventions": CONVENTIONS,
    }
    if studio.spec.writes(*OF_CAMERA):
        info = studio.info
        about["camera"] = {
            "name": studio.spec.camera, "width": info.width, "height": info.height, "k": info.k.tolist(),
            "distortion_model": info.distortion_model, "d": info.d.tolist(), "effects": list(studio.effects),
        }  # fmt: skip
    if studio.sonar is not None:
        figures = {key: value for key, value in vars(studio.sonar.model).items() if key != "strengths_db"}
        about["sonar"] = {"name": studio.sonar.name, "kind": studio.sonar.model.kind, **figures}
    return about


def _coco(
    studio: Studio, about: Mapping[str, Any], records: Sequence[Mapping[str, Any]], kind: str, annotations: str
) -> str:
    spec, info = studio.spec, studio.info
    if kind == "sonar":
        assert studio.sonar is not None
        height, width = studio.sonar.model.range_bins, getattr(studio.sonar.model, "beams", 0)
    else:
        height, width = info.height, info.width
    pictures = []
    for record in records:
        number = record["frame"]
        name = Path(file_name(spec, kind, number)).name if kind in folders(spec) else f"{number:06d}.{spec.pictures}"
        pictures.append(({"id": number, "file_name": name, "width": width, "height": height}, record[annotations]))
    origin = {key: about[key] for key in ("uwsim", "scenario_name", "scenario_digest", "build", "seed")}
    return _dumped(coco(origin, studio.class_names, pictures))


def _dumped(content: Any) -> str:
    return json.dumps(content) + "\n"


def split_of_frames(count: int, val_share: float, seed: int, *, in_sequence: bool) -> list[str]:
    """Return the split of each frame.

    round(val_share * count) frames are used for validation: random frames if the poses are random, or whole stretches
    of a sequence, since neighbouring frames look alike.
    """
    held_back = round(val_share * count)
    splits = np.full(count, SPLITS[0], dtype="<U5")
    if in_sequence:
        stretches = max(1, min(STRETCHES, held_back))
        lengths = [len(part) for part in np.array_split(np.empty(held_back), stretches)]
        for part, length in zip(np.array_split(np.arange(count), stretches), lengths, strict=True):
            first = (len(part) - length) // 2
            splits[part[first : first + length]] = SPLITS[1]
    else:
        splits[np.random.default_rng([seed, count]).permutation(count)[:held_back]] = SPLITS[1]
    return [str(split) for split in splits]
