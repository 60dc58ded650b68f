"""COCO instance format: boxes and masks of the objects in pictures. https://cocodataset.org/#format-data."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from uwsim.campaigns.datasets.formats.masks import bounds, run_lengths

STUFF = ("nothing", "terrain")
"""Classes that are not objects: they have masks, but no boxes."""


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
                extra = {"piece": piece} if piece else {}
                found.append(annotation(mask, class_of_label[label], names[label], label, distances_m, extra))
    return found


def annotation(
    mask: NDArray[np.bool_], category: int, name: str, label: int, distances_m: NDArray[np.float32],
    extra: Mapping[str, Any] | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return the annotation, without an id, of an object with this mask. extra: fields before the distance."""
    return {
        "category_id": category,
        "segmentation": run_lengths(mask),
        "area": int(mask.sum()),
        "bbox": bounds(mask),
        "iscrowd": 0,
        "name": name,
        "instance": label,
        **(extra or {}),
        "distance_m": round(float(np.median(distances_m[mask])), 3),
    }


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
