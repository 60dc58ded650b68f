"""A push from outside by schedule, on a vehicle or a loose body."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import model_validator

from uwsim.scenario.spec.fields import InRange, Model, broken

Newtons = Annotated[float, InRange(-1e9, 1e9, "N")]
NewtonMetres = Annotated[float, InRange(-1e9, 1e9, "N m")]


class AppliedWrench(Model):
    """A force and torque that act on a body from outside, at its origin, in an interval of simulated time.

    force_n, torque_nm: along the axes. axes: `body`, which turn with the vehicle, or `world`. until_s: by default the
    end of the run.
    """

    force_n: tuple[Newtons, Newtons, Newtons] = (0.0, 0.0, 0.0)
    torque_nm: tuple[NewtonMetres, NewtonMetres, NewtonMetres] = (0.0, 0.0, 0.0)
    axes: Literal["body", "world"] = "body"
    from_s: Annotated[float, InRange(0, 1e9, "s")] = 0.0
    until_s: Annotated[float, InRange(0, 1e9, "s")] | None = None

    @model_validator(mode="after")
    def _ends_after_it_begins(self) -> AppliedWrench:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise broken(f"must be after from_s, {self.from_s:g} s", at=("until_s",), value=self.until_s, unit="s")
        return self
