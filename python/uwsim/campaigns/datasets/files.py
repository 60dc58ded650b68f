"""Files of a dataset: pixels of PNG files, masks and boxes in COCO's format, boxes in YOLO's.

COCO: https://cocodataset.org/#format-data; YOLO: https://docs.ultralytics.com/datasets/detect/. Run lengths go column
by column, starting with pixels outside the mask, as plain lists, which pycocotools, torchvision and Detectron2 read;
torchvision cannot read the compressed form.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.base.arrays import Floats

FARTHEST_M = 65.535
"""The largest depth in millimetres that fits into 16 bits."""
STUFF = ("nothing", "terrain")
"""Classes that are not objects: they have masks, but no boxes."""


def depth_pixels(depth_m: NDArray[np.float32]) -> NDArray[np.uint16]:
    """Return depth along the optical axis in mm, as in ScanNet, TUM and nerfstudio; 0: no hit, or beyond 65.535 m."""
    near = depth_m <= FARTHEST_M
    return np.where(near, np.rint(1000.0 * np.where(near, depth_m, 0.0)), 0).astype(np.uint16)


def normal_pixels(
    normals_world: NDArray[np.float32], world_from_optical: Floats, rays: NDArray[np.float32]
) -> NDArray[np.uint8]:
    """Return normals in the optical frame, facing the camera, as round(127.5 (n + 1)); 0, 0, 0 if nothing is hit.

    rays: (H, W, 2), X/Z and Y/Z of each pixel.
    """
    turn = world_from_optical[:3, :3].T.astype(np.float32)
    x, y, z = turn @ normals_world.reshape(-1, 3).T  # one array per axis, which is twice as fast in NumPy
    across, down = rays.reshape(-1, 2).T
    side = np.where(x * across + y * down + z > 0.0, np.float32(-127.5), np.float32(127.5))
    hit = (x != 0.0) | (y != 0.0) | (z != 0.0)
    pixels = np.empty((len(x), 3), np.uint8)
    for channel, values in enumerate((x, y, z)):
        pixels[:, channel] = np.rint(values * side + np.float32(127.5)) * hit
    return pixels.reshape(normals_world.shape)


def level_pixels(level_db: NDArray[np.float32], limits_db: tuple[float, float]) -> NDArray[np.uint8]:
    """Return grey levels, linear from the lower limit (black) to the upper limit (white)."""
    low, high = limits_db
    return np.asarray(np.rint(255.0 * np.clip((level_db - low) / (high - low), 0.0, 1.0)), np.uint8)


def run_lengths(mask: NDArray[np.bool_]) -> dict[str, Any]:
    """Return a mask (H, W) as a COCO `segmentation`."""
    flat = mask.ravel(order="F")
    edges = np.flatnonzero(np.diff(flat)) + 1
    ends = np.concatenate([[0], edges, [flat.size]])
    counts = np.diff(ends).tolist()
    return {"size": list(mask.shape), "counts": [0, *counts] if flat.size and flat[0] else counts}


def bounds(mask: NDArray[np.bool_]) -> list[int]:
    """Return x, y, width, height [pixels] of the bounding box of a non-empty mask (H, W)."""
    rows, columns = np.flatnonzero(mask.any(axis=1)), np.flatnonzero(mask.any(axis=0))
    left, top = int(columns[0]), int(rows[0])
    return [left, top, int(columns[-1]) - left + 1, int(rows[-1]) - top + 1]


def annotations_of(
    labels: NDArray[np.uint16], class_of_label: Sequence[int], names: Sequence[str], distances_m: NDArray[np.float32],
    min_pixels: int, pieces: NDArray[np.uint32] | None = None,
) -> list[dict[str, Any]]:  # fmt: skip
    """Return the annotations for the objects in a picture, without ids.

    labels: (H, W). class_of_label: the class index of each label. names: the name of each label. distances_m: (H, W),
    the distance of each pixel. min_pixels: objects with fewer pixels are omitted. In addition to the COCO fields, an
    annotation has the object's name, its label and the median distance of its pixels. pieces: (H, W), the number of
    each piece of cover, else 0; each is an object of its own, with its number.
    """
    found = []
    for label in np.flatnonzero(np.bincount(labels.ravel())).tolist():
        if class_of_label[label] < len(STUFF):
            continue
        alike = labels == label
        seen, counts = ([0], [min_pixels]) if pieces is None else np.unique(pieces[alike], return_counts=True)
        for piece in [int(number) for number, count in zip(seen, counts, strict=True) if count >= min_pixels]:
            mask = alike if pieces is None else alike & (pieces == piece)
            if int(mask.sum()) >= min_pixels:
                found.append({
                    "category_id": class_of_label[label], "segmentation": run_lengths(mask), "area": int(mask.sum()),
                    "bbox": bounds(mask), "iscrowd": 0, "name": names[label], "instance": label,
                    **({"piece": piece} if piece else {}),
                    "distance_m": round(float(np.median(distances_m[mask])), 3),
                })  # fmt: skip
    return found


def coco(
    about: Mapping[str, Any],
    class_names: Sequence[str],
    pictures: Iterable[tuple[dict[str, Any], list[dict[str, Any]]]],
) -> dict[str, Any]:
    """Return the contents of a COCO file. pictures: pairs of an `images` entry, with an id, and its annotations."""
    images: list[dict[str, Any]] = []
    annotations: list[dict[str, Any]] = []
    for image, things in pictures:
        images.append(image)
        for thing in things:  # ids begin at 1: pycocotools treats annotation 0 as no match
            annotations.append({"id": len(annotations) + 1, "image_id": image["id"], **thing})
    categories = [
        {"id": number, "name": name, "supercategory": "thing"}
        for number, name in enumerate(class_names)
        if number >= len(STUFF)
    ]
    return {"info": dict(about), "licenses": [], "images": images, "annotations": annotations, "categories": categories}


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
