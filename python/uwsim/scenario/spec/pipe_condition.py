"""`condition` of a pipeline: its joints and anodes, and what an inspection is to find on it."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Literal

from pydantic import Field, model_validator

from uwsim.scenario.spec.fields import InRange, Model, broken

FeatureKind = Literal["damage", "span", "burial", "debris", "leak"]
Along = Annotated[float, InRange(0, 1e6, "m")]
Length = Annotated[float, InRange(0.1, 1000, "m")]
Count = Annotated[int, InRange(0, 100)]
USUAL_M: dict[FeatureKind, float] = {"damage": 0.8, "span": 8.0, "burial": 8.0, "debris": 0.8, "leak": 0.3}


class PipeFeature(Model):
    """A place on a pipeline where something is the matter.

    kind: damage (the coating is missing, down to the steel), span (the pipe hangs above the bed), burial (it vanishes
    in the bed), debris (a bottle, can, tyre, plank or brick lies across it) or leak (bubbles of gas rise from a rusty
    place). at_m: the distance of its middle from the first point, along the line on the chart. length_m: by default
    0.8 m for damage and debris, 0.3 m for a leak, 8 m for the others. height_m: of a span's middle above the pipe's
    usual place. clock_h: where damage or a leak is on the circumference, as on a clock seen along the line: 12 is on
    top. rate_l_min: volume of gas that leaks, at the pressure there.
    """

    kind: FeatureKind
    at_m: Along
    length_m: Length | None = None
    height_m: Annotated[float, InRange(0, 5, "m")] = 0.4
    clock_h: Annotated[float, InRange(0, 12, "h")] = 12.0
    rate_l_min: Annotated[float, InRange(0.01, 10_000, "l/min")] | None = None

    @property
    def extent_m(self) -> float:
        """Its length, or what is usual."""
        return self.length_m if self.length_m is not None else USUAL_M[self.kind]


class PipeCondition(Model):
    """Joints and anodes of a pipeline, and its features: those of the list, and others at places drawn from a seed.

    joint_m: distance between field joints, where lengths of 12.2 m (40 feet) were welded together. anode_m: distance
    between bracelet anodes; of pipelines at most 300 m (DNV-RP-F103, 2010, 5.6.3), here by default every other length.
    features: at places that are given. damages, spans, burials, debris, leaks: how many more, at random places that do
    not overlap. seed: of those.
    """

    joint_m: Annotated[float, InRange(1, 1000, "m")] = 12.2
    anode_m: Annotated[float, InRange(1, 1000, "m")] = 24.4
    features: Annotated[tuple[PipeFeature, ...], Field(max_length=1000)] = ()
    damages: Count = 0
    spans: Count = 0
    burials: Count = 0
    debris: Count | None = None
    leaks: Count | None = None
    seed: Annotated[int, InRange(0, 2**63 - 1)] = 0

    @model_validator(mode="after")
    def _is_not_overlapping(self) -> PipeCondition:
        taken = sorted((one.at_m - one.extent_m / 2, one.at_m + one.extent_m / 2) for one in self.features)
        for (_, end), (start, _) in pairwise(taken):
            if start < end:
                raise broken(f"two features overlap at {start:g} m", at=("features",), value=start, unit="m")
        return self
