"""YOLO box format: one text file per picture. https://docs.ultralytics.com/datasets/detect/."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from uwsim.campaigns.datasets.formats.coco import STUFF


def yolo_lines(things: Sequence[Mapping[str, Any]], width: int, height: int) -> str:
    """Return the text file for a picture from COCO annotations: class, then centre and size as picture fractions."""
    lines = []
    for thing in things:
        left, top, across, down = thing["bbox"]
        box = (left + 0.5 * across) / width, (top + 0.5 * down) / height, across / width, down / height
        lines.append(f"{thing['category_id'] - len(STUFF)} " + " ".join(f"{share:.6f}" for share in box) + "\n")
    return "".join(lines)


def yolo_yaml(class_names: Sequence[str]) -> str:
    """Return the contents of data.yaml, which names the picture lists and the classes, numbered from 0."""
    names = "".join(f"  {number}: {name}\n" for number, name in enumerate(class_names[len(STUFF) :]))
    return f"train: train.txt\nval: val.txt\nnames:\n{names}"
