"""View: the camera and size of an environment's rendered pictures."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

RENDER_MODES = ["rgb_array"]


@dataclass(frozen=True)
class View:
    """How an environment is rendered.

    camera: a camera on the vehicle, such as "chase" or "front". width, height: size in pixels.
    """

    camera: str = "chase"
    width: int = 480
    height: int = 270

    def checked(self, render_mode: str | None) -> Self:
        """Return this view. Raises ValueError for an unknown render mode."""
        if render_mode not in (None, *RENDER_MODES):
            raise ValueError(f"render_mode = {render_mode!r}: must be None or one of {', '.join(RENDER_MODES)}")
        return self
