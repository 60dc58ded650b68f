"""Draw docs/guides/dataset.jpg: frames of a dataset of the lake, with the labels written for each."""

from __future__ import annotations

import json
import tempfile
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.patches import Rectangle
from numpy.typing import NDArray
from PIL import Image

import uwsim

OUT = Path(__file__).resolve().parents[2] / "docs" / "guides" / "dataset.jpg"
FRAMES, SHOWN = 40, 4
COLOURS = ListedColormap(["#10151c", "#7a6a55", "#8d99ae", "#f4a261", "#e76f51", "#2a9d8f", "#e9c46a"])
TITLES = ("colour and boxes", "depth", "normals", "classes", "sonar", "its classes")


def main() -> None:
    """Generate a dataset, and draw the frames that show the most objects."""
    with tempfile.TemporaryDirectory() as folder:
        made = uwsim.make_dataset(
            "lake",
            folder,
            FRAMES,
            seed=4,
            workers=0,
            size=(480, 270),
            write=("rgb", "depth", "normals", "classes", "boxes", "sonar"),
            look_at=("gate", "pipeline"),
            distance_m=(2.0, 7.0),
            vary={
                "optics.jerlov": {"choices": ["II", "III", "1C"]},
                "optics.sun_elevation_deg": {"low": 20.0, "high": 80.0},
                "rov.lamps.front.on": {"choices": [True, False]},
            },
        )
        draw(made.out)


def draw(data: Path) -> None:
    """Draw one row for each of the frames that show the most objects."""
    boxes: dict[int, list[dict[str, Any]]] = {}
    for split in ("train", "val"):
        for thing in json.loads((data / f"annotations/instances_{split}.json").read_text())["annotations"]:
            boxes.setdefault(thing["image_id"], []).append(thing)
    lines = [json.loads(line) for line in (data / "frames.jsonl").read_text().splitlines()]
    fullest = sorted(lines, key=lambda line: -len(boxes.get(line["frame"], [])))[:SHOWN]
    figure, rows = plt.subplots(
        SHOWN, len(TITLES), figsize=(15.5, 6.9), width_ratios=[16] * 4 + [8] * 2,
        gridspec_kw={"left": 0.0, "right": 1.0, "bottom": 0.0, "top": 0.965, "wspace": 0.02, "hspace": 0.03},
    )  # fmt: skip
    for row, line in zip(rows, fullest, strict=True):
        pictures = {kind: np.asarray(Image.open(data / name)) for kind, name in line["files"].items()}
        _show(row[0], pictures["rgb"])
        for thing in boxes.get(line["frame"], []):
            x, y, width, height = thing["bbox"]
            row[0].add_patch(Rectangle((x, y), width, height, fill=False, edgecolor="#ffd166", linewidth=1.2))
            row[0].text(
                x + 4, max(y, 4) + 14, f"{thing['name']} {thing['distance_m']:.1f} m", color="#ffd166", fontsize=7
            )
        depth = pictures["depth"].astype(float) / 1000.0
        _show(row[1], np.where(depth > 0, depth, np.nan), cmap="viridis_r", vmin=0, vmax=25)
        _show(row[2], pictures["normals"])
        _show(row[3], pictures["classes"], cmap=COLOURS, vmin=-0.5, vmax=6.5)
        _show(row[4], pictures["sonar"], cmap="copper", aspect="auto")
        _show(row[5], pictures["sonar_classes"], cmap=COLOURS, vmin=-0.5, vmax=6.5, aspect="auto")
    for axes, title in zip(rows[0], TITLES, strict=True):
        axes.set_title(title, fontsize=9)
    figure.savefig(OUT, dpi=110, pil_kwargs={"quality": 82})


def _show(axes: Axes, picture: NDArray[Any], **options: Any) -> None:
    axes.imshow(picture, interpolation="nearest", **options)
    axes.set_axis_off()


if __name__ == "__main__":
    main()
