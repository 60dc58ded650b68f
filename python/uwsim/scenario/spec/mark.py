"""Marks on a board: shapes and letters, which form its picture."""

from __future__ import annotations

from typing import Annotated, Literal, get_args

from pydantic import Field, model_validator

from uwsim.scenario.spec.camera import Colour
from uwsim.scenario.spec.fields import Degrees, InRange, Model, broken

Shape = Literal["disc", "ring", "square", "triangle", "cross", "star", "arrow", "stripes", "fish", "text"]
SHAPES: tuple[str, ...] = get_args(Shape)
Place = Annotated[float, InRange(-100, 100, "m")]


class Mark(Model):
    """A mark on a board's front. Later ones cover earlier ones.

    shape: what it is. text: capital letters, figures and spaces, for shape `text`. at_m: its middle, to the right and
    up from the board's as one looks at the front. size_m: its width, and a letter's height. turned_deg:
    counter-clockwise as one looks at the front; an arrow points up before. colour: its albedo.
    """

    shape: Shape
    text: Annotated[str, Field(pattern=r"^[A-Z0-9 ]{1,12}$")] | None = None
    at_m: tuple[Place, Place] = (0.0, 0.0)
    size_m: Annotated[float, InRange(0.005, 100, "m")]
    turned_deg: Degrees = 0.0
    colour: Colour

    @model_validator(mode="after")
    def _has_its_text(self) -> Mark:
        if (self.text is not None) != (self.shape == "text"):
            raise broken("belongs to shape `text`, and only to it", at=("text",), value=self.text)
        return self
