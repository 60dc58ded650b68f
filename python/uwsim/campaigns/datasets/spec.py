"""The validated options of `uwsim dataset`, which define the contents of a dataset."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Annotated, Any, Literal, get_args

from pydantic import Field, ValidationInfo, field_validator, model_validator

from uwsim.base.texts.json_text import json_value
from uwsim.instruments.cameras.effects import effects_on
from uwsim.scenario.spec.camera import LARGEST_SIDE
from uwsim.scenario.spec.fields import InRange, Model, broken
from uwsim.scenario.variation import Variation

Product = Literal["rgb", "depth", "normals", "instances", "classes", "boxes", "yolo", "arrays", "sonar", "multibeam"]
PRODUCTS: tuple[str, ...] = get_args(Product)
"""Everything that can be written for a frame."""
USUAL: tuple[Product, ...] = ("rgb", "depth", "normals", "instances", "classes", "boxes")
OF_CAMERA = {"rgb", "depth", "normals", "instances", "classes", "boxes", "yolo", "arrays"}
MAX_FRAMES = 1_000_000
MIN_PIXELS = 16
Pixels = Annotated[int, InRange(1, LARGEST_SIDE, "pixels")]
Metres = Annotated[float, InRange(0.01, 1000, "m")]


class DatasetSpec(Model):
    """The options of a dataset, except for a track.

    Text is read as on the command line. From Python, vary may also be a dictionary of texts, tuples (low, high), lists
    of values, or dictionaries as in a sweep's file.

    scenario: the name of a packaged scenario, a file, or such a file's content. n: number of frames. seed: seed of all
    random draws, which replaces the scenario's. vehicle: name of the vehicle; by default the first. camera: a camera of
    the vehicle or the station, such as down; of a --sequence also several, comma-separated. size: pixels, WxH; by
    default the camera's own. effects: those of the picture, on, off, or joined by +, as for Camera.capture. without:
    effects to omit, such as wobble; of a --sequence, instruments, such as multibeam. write: outputs, comma-separated:
    rgb, depth, normals, instances, classes, boxes, yolo, arrays, sonar, multibeam. pictures: format of rgb, png
    or jpg. sonar: the forward-looking sonar; by default the first. look_at: names or classes of targets, also of cover
    and fish, comma-separated, such as gate,pipeline; by default all obstacles, vehicles and the terrain. distance_m:
    distance to the target [m], LOW..HIGH; by default up to 0.6 of the water's visibility. clearance_m: free space
    around hull and camera. pitch_max_deg: largest pitch of the vehicle, up and down. roll_max_deg: largest roll of the
    vehicle, to either side. empty_share: share of the frames without any object in the picture or, with look_at,
    without any of its targets. crowded_share: share of the frames with many, which are of the pose that shows the most
    objects of 16. label_range_m: objects farther away have no labels; by default the water's visibility. min_pixels:
    smaller objects have no box. val_share: share of the frames for validation. vary: a parameter drawn for each frame,
    NAME=LOW..HIGH or NAME=A,B,C, such as optics.jerlov=II,3C; may be repeated.
    """

    scenario: str | dict[str, Any]
    n: Annotated[int, InRange(1, MAX_FRAMES)] = 100
    seed: Annotated[int, InRange(0, 2**63 - 1)] | None = None
    vehicle: str | None = None
    camera: str = "front"
    size: tuple[Pixels, Pixels] | None = None
    effects: str | tuple[str, ...] = "on"
    without: tuple[str, ...] = ()
    write: Annotated[tuple[Product, ...], Field(min_length=1)] = USUAL
    pictures: Literal["png", "jpg"] = "png"
    sonar: str | None = None
    look_at: tuple[str, ...] | None = None
    distance_m: tuple[Metres, Metres] | None = None
    clearance_m: Annotated[float, InRange(0, 100, "m")] = 0.2
    pitch_max_deg: Annotated[float, InRange(0, 90, "deg")] = 15.0
    roll_max_deg: Annotated[float, InRange(0, 180, "deg")] = 5.0
    empty_share: Annotated[float, InRange(0, 1)] = 0.0
    crowded_share: Annotated[float, InRange(0, 1)] = 0.0
    label_range_m: Annotated[float, InRange(0.01, 1e6, "m")] | None = None
    min_pixels: Annotated[int, InRange(1, LARGEST_SIDE**2, "pixels")] = MIN_PIXELS
    val_share: Annotated[float, InRange(0, 1)] = 0.2
    vary: Annotated[dict[str, Variation], Field(max_length=200)] = Field({})

    @field_validator("without", "write", "look_at", "effects", "size", "distance_m", "vary", mode="before")
    @classmethod
    def _read(cls, value: Any, info: ValidationInfo) -> Any:
        """Read text, and variations that are written briefly."""
        if info.field_name == "vary":
            return _variations(value)
        return READ.get(str(info.field_name), _listed)(value) if isinstance(value, str) else value

    @model_validator(mode="after")
    def _has_no_ineffective_keys(self) -> DatasetSpec:
        if len(set(self.write)) < len(self.write):
            raise broken("must not contain duplicates", at=("write",), value=", ".join(self.write))
        if self.distance_m is not None and self.distance_m[0] > self.distance_m[1]:
            raise broken(
                "must be the minimum, then the maximum", at=("distance_m",), value=list(self.distance_m), unit="m"
            )
        if (share := self.empty_share + self.crowded_share) > 1.0:
            raise broken(
                "must be at most 1, together with empty_share", at=("crowded_share",), value=self.crowded_share
            )
        if share and not self.writes(*OF_CAMERA):
            at = "empty_share" if self.empty_share else "crowded_share"
            raise broken("has no effect unless `write` contains an output of the camera", at=(at,), value=share)
        if self.sonar is not None and "sonar" not in self.write:
            raise broken("has no effect unless `write` contains sonar", at=("sonar",), value=self.sonar)
        if self.pictures != "png" and "rgb" not in self.write:
            raise broken("has no effect unless `write` contains rgb", at=("pictures",), value=self.pictures)
        if self.label_range_m is not None and not self.writes("instances", "classes", "boxes", "yolo"):
            rule = "has no effect unless `write` contains instances, classes, boxes or yolo"
            raise broken(rule, at=("label_range_m",), value=self.label_range_m, unit="m")
        if self.min_pixels != MIN_PIXELS and not self.writes("boxes", "yolo", "sonar"):
            rule = "has no effect unless `write` contains boxes, yolo or sonar"
            raise broken(rule, at=("min_pixels",), value=self.min_pixels)
        if "yolo" in self.write and "rgb" not in self.write:
            raise broken("contains yolo, which needs rgb, too", at=("write",))
        for name, variation in self.vary.items():
            if variation.steps is not None:
                raise broken("is for the grid of a sweep; here values are drawn at random", at=("vary", name, "steps"))
        return self

    @property
    def scenario_name(self) -> str:
        """The scenario as messages name it."""
        return self.scenario if isinstance(self.scenario, str) else str(self.scenario["name"])

    @property
    def effects_on(self) -> tuple[str, ...]:
        """Return the names of the effects to apply. Raises ValueError if a name is unknown."""
        off = effects_on(self.without)
        return tuple(name for name in effects_on(self.effects) if name not in off)

    def writes(self, *products: str) -> bool:
        """Return whether any of these products is written."""
        return not set(products).isdisjoint(self.write)


def _listed(text: str) -> tuple[str, ...]:
    return tuple(part.strip() for part in text.split(",") if part.strip())


def _joined(text: str) -> str | tuple[str, ...]:
    return text if text in ("on", "off") else tuple(text.split("+"))


def _size(text: str) -> tuple[int, int]:
    if (found := re.fullmatch(r"(\d{1,9})x(\d{1,9})", text.lower())) is None:
        raise broken("must be WIDTHxHEIGHT in pixels, such as 320x240")
    return int(found[1]), int(found[2])


def _interval(text: str) -> tuple[float, float]:
    low, _, high = text.partition("..")
    try:
        return float(low), float(high)
    except ValueError:
        raise broken("must be LOW..HIGH, such as 1..6") from None


READ: dict[str, Callable[[str], Any]] = {"effects": _joined, "size": _size, "distance_m": _interval}
"""How the text of a field is read, if not as names that are separated by commas."""


def _variations(vary: Any) -> Any:
    """Return the variations by name of a dictionary, or of texts NAME=VALUES."""
    if isinstance(vary, tuple | list):
        pairs = [str(text).partition("=") for text in vary]
        if not all(name and values for name, _, values in pairs):
            raise broken("must be NAME=LOW..HIGH or NAME=A,B,C")
        vary = {name: values for name, _, values in pairs}
    return {name: variation_of(value) for name, value in vary.items()} if isinstance(vary, Mapping) else vary


def variation_of(value: Any) -> Any:
    """Return a variation, written briefly, as the dictionary of a sweep's file; anything else unchanged."""
    if isinstance(value, str):
        low, dots, high = value.partition("..")
        parts = [low, high] if dots else value.split(",")
        value = tuple(map(_value, parts)) if dots else [_value(part) for part in parts]
    if isinstance(value, tuple) and len(value) == 2:
        return {"low": value[0], "high": value[1]}
    return {"choices": value} if isinstance(value, list) else value


def _value(text: str) -> Any:
    """Parse a number or boolean; return any other text unchanged."""
    try:
        return json_value(text, "vary")
    except ValueError:
        return text
