"""The fault `tether`: a tether of a vehicle or an object breaks, or bears less."""

from __future__ import annotations

import math
from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.base.named import did_you_mean
from uwsim.scenario.spec.fault import FaultModel, FaultyVehicle
from uwsim.scenario.spec.fields import InRange, Name, broken


class TetherFault(FaultModel):
    """The vehicle's tether breaks at once, or, with breaking_load_n, is damaged and breaks under a smaller load.

    A broken tether remains broken. object: the loose body whose tether it is instead. at_m: the length from its anchor
    at which it breaks; by default, and if less than that is out, at its other end. breaking_load_n: while the fault
    lasts, it breaks where the tension exceeds this.
    """

    kind: Literal["tether"]
    object: Name | None = None
    at_m: Annotated[float, InRange(0, 20_000, "m")] | None = None
    breaking_load_n: Annotated[float, InRange(0.1, 1e9, "N")] | None = None

    @model_validator(mode="after")
    def _breaks_at_once_or_under_load(self) -> TetherFault:
        if self.at_m is not None and self.breaking_load_n is not None:
            raise broken("must not be given with breaking_load_n: the load decides where it breaks", at=("at_m",))
        return self

    def check(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        if self.object is None and vehicle.name not in vehicle.tethers:
            raise ValueError(f"kind = 'tether': vehicle '{vehicle.name}' has no tether")
        if self.object is not None and self.object not in vehicle.tethers:
            known = list(vehicle.tethers)
            rule = f"must be one with a tether, {', '.join(known) or 'of which there is none'}"
            raise ValueError(f"object = {self.object!r}: {rule}{did_you_mean(self.object, known)}")

    def begin(self, vehicle: FaultyVehicle) -> None:
        """See FaultModel."""
        if self.breaking_load_n is None:
            tether = vehicle.tethers[self.object or vehicle.name]
            out_m = tether.length_m
            tether.cut(out_m if self.at_m is None else min(self.at_m, out_m))

    def tether_bears_n(self, of: str, vehicle: str) -> float:
        """See FaultModel."""
        return math.inf if self.breaking_load_n is None or of != (self.object or vehicle) else self.breaking_load_n
