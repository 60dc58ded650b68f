"""Train a small detector on labelled pictures of one world, and try it on those of another.

    pip install scikit-learn
    python tools/learn/detector.py starfish --train wreck --test fish_farm

Makes both datasets in --data, unless they are there; fits a random forest to colour and texture about each pixel, much
of it relative to the surroundings, so that the water's colour matters less; joins the pixels that it marks to objects;
and prints precision and recall of their boxes.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import cv2
import numpy as np
import typer
from numpy.typing import NDArray
from sklearn.ensemble import RandomForestClassifier

import uwsim

SIZE, STRIDE = (320, 240), 3
SCALES_PX = (3, 7, 15, 31, 81)
LEAST_PIXELS, ENOUGH_PIXELS = 60, 150
"""Annotated at all, and large enough to count as missed."""
SAMPLES, TREES, MATCH = 150, 120, 0.3
"""Pixels of a kind for each frame, trees, and the overlap of boxes that counts as found."""
Floats = NDArray[np.float32]


class Example(NamedTuple):
    """A picture, the masks of the objects in it, and their boxes: left, top, right, bottom."""

    rgb: NDArray[np.uint8]
    masks: list[NDArray[np.bool_]]
    boxes: list[NDArray[np.float64]]


def main(
    wanted: Annotated[str, typer.Argument(help="The class to find.")] = "starfish",
    train: Annotated[str, typer.Option(help="Scenario to train on.")] = "wreck",
    test: Annotated[str, typer.Option(help="Scenario to find it in.")] = "fish_farm",
    frames: Annotated[int, typer.Option(min=4, help="Frames to train on; half as many to test.")] = 60,
    sure: Annotated[float, typer.Option(help="The probability from which a pixel counts.")] = 0.6,
    data: Annotated[Path, typer.Option(help="Folder for the datasets.")] = Path("detector"),
) -> None:
    """Train, find and print."""
    forest = trained(examples(data / train, train, frames, 1, wanted))
    counts = np.zeros(4, int)
    for example in examples(data / test, test, frames // 2, 2, wanted):
        counts += score(detections(forest, example.rgb, sure), example)
    right, boxes, found, there = counts.tolist()
    print(f"{wanted} in {test}, trained in {train}: precision {right / max(boxes, 1):.2f} of {boxes} boxes, "
          f"recall {found / max(there, 1):.2f} of {there} objects")  # fmt: skip


def examples(folder: Path, scenario: str, frames: int, seed: int, wanted: str) -> list[Example]:
    """Return the frames of a dataset, which is made first if it does not exist."""
    if not folder.exists():
        uwsim.make_dataset(
            scenario, folder, frames, seed=seed, workers=0, size=SIZE, look_at=("terrain",), distance_m=(0.7, 1.6),
            pitch_max_deg=60.0, clearance_m=0.05, write=("rgb", "boxes"), val_share=0.0, min_pixels=LEAST_PIXELS,
        )  # fmt: skip
    about = json.loads((folder / "annotations/instances_train.json").read_text())
    (category,) = (each["id"] for each in about["categories"] if each["name"] == wanted)
    found: dict[int, list[NDArray[np.bool_]]] = {image["id"]: [] for image in about["images"]}
    for each in about["annotations"]:
        if each["category_id"] == category:
            found[each["image_id"]].append(mask_of(each["segmentation"]))
    pictures = {image["id"]: cv2.imread(str(folder / "images" / image["file_name"])) for image in about["images"]}
    return [
        Example(pictures[k][..., ::-1].copy(), masks, [box_of(mask) for mask in masks]) for k, masks in found.items()
    ]


def mask_of(runs: dict[str, Any]) -> NDArray[np.bool_]:
    """Return the mask (H, W) of COCO's run lengths, which go down the columns and begin with the number of zeros."""
    values = np.arange(len(runs["counts"])) % 2 == 1
    return np.repeat(values, runs["counts"]).reshape(runs["size"][::-1]).T


def box_of(mask: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Return left, top, right and bottom (4,) of a mask."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    return np.array([columns[0], rows[0], columns[-1] + 1, rows[-1] + 1], np.float64)


def features(rgb: NDArray[np.uint8]) -> Floats:
    """Return colours and textures (H, W, k) at several scales, relative to each larger one."""
    lab = cv2.cvtColor(rgb, cv2.COLOR_RGB2LAB).astype(np.float32)
    light = np.log(lab[..., 0] + 8.0)
    slope = np.hypot(cv2.Sobel(light, cv2.CV_32F, 1, 0), cv2.Sobel(light, cv2.CV_32F, 0, 1))
    planes = np.dstack([light, lab[..., 1:], slope])
    means = [cv2.boxFilter(planes, -1, (scale, scale)) for scale in SCALES_PX]
    spread = [np.sqrt(np.maximum(cv2.boxFilter(light**2, -1, (s, s)) - m[..., 0] ** 2, 0)) for s, m in
              zip(SCALES_PX, means, strict=True)]  # fmt: skip
    relative = [small - large for k, small in enumerate(means) for large in means[k + 1 :]]
    return np.dstack([means[1][..., 1:], *relative, *spread]).astype(np.float32)


def trained(seen: list[Example]) -> RandomForestClassifier:
    """Return a forest fitted to as many pixels with and without the class of each frame."""
    random = np.random.default_rng(0)
    inputs, is_wanted = [], []
    for example in seen:
        about = features(example.rgb).reshape(SIZE[0] * SIZE[1], -1)
        mask = np.any([np.zeros(SIZE[::-1], bool), *example.masks], axis=0).ravel()
        for value, count in ((True, 2 * SAMPLES), (False, 2 * SAMPLES)):
            where = np.flatnonzero(mask == value)
            inputs.append(about[random.choice(where, min(count, len(where)), replace=False)])
            is_wanted.append(np.full(len(inputs[-1]), value))
    forest = RandomForestClassifier(TREES, min_samples_leaf=4, class_weight="balanced", n_jobs=2, random_state=0)
    return forest.fit(np.concatenate(inputs), np.concatenate(is_wanted))


def detections(forest: RandomForestClassifier, rgb: NDArray[np.uint8], sure: float) -> list[NDArray[np.float64]]:
    """Return the boxes of connected pixels that the forest marks."""
    coarse = features(rgb)[::STRIDE, ::STRIDE]
    chance = forest.predict_proba(coarse.reshape(-1, coarse.shape[-1]))[:, 1].reshape(coarse.shape[:2])
    full = cv2.GaussianBlur(cv2.resize(chance.astype(np.float32), SIZE), (0, 0), STRIDE)
    _, _, stats, _ = cv2.connectedComponentsWithStats((full >= sure).astype(np.uint8))
    return [
        np.array([left, top, left + across, top + down], np.float64)
        for left, top, across, down, area in stats[1:].tolist()
        if area >= ENOUGH_PIXELS
    ]


def score(boxes: list[NDArray[np.float64]], example: Example) -> NDArray[np.int_]:
    """Return how many boxes are right, of how many, and how many large objects are found, of how many (4,)."""
    shares = np.array([[overlap(box, truth) for truth in example.boxes] for box in boxes])
    hits = shares.reshape(len(boxes), len(example.boxes)) >= MATCH
    large = np.array([mask.sum() >= ENOUGH_PIXELS for mask in example.masks], bool)
    return np.array([hits.any(axis=1).sum(), len(boxes), (hits.any(axis=0) & large).sum(), large.sum()])


def overlap(one: NDArray[np.float64], other: NDArray[np.float64]) -> float:
    """Return the intersection of two boxes over their union."""
    size = np.minimum(one[2:], other[2:]) - np.maximum(one[:2], other[:2])
    common = float(np.prod(np.maximum(size, 0)))
    return common / (float(np.prod(one[2:] - one[:2]) + np.prod(other[2:] - other[:2])) - common)


if __name__ == "__main__":
    typer.run(main)
