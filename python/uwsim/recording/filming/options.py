"""The options of a film, which are the flags of `uwsim recording film` and the keywords of make_film."""

from __future__ import annotations

import re
from dataclasses import dataclass

from uwsim.base.options import OptionError, Options, option, require_within

QUALITIES = {"draft": 1, "good": 4, "high": 16}
"""Pictures of which each frame is the mean, by quality."""
MAX_PIXELS = 8192
"""Most pixels along an edge: those of a camera."""


@dataclass(frozen=True)
class FilmOptions(Options):
    """The options of a film. From Python, size may also be (width, height)."""

    camera: str = option(
        "chase", "chase, orbit, a camera of the vehicle, or a CSV file: time_s,x_m,y_m,z_m,at_x_m,at_y_m,at_z_m."
    )
    vehicle: str | None = option(None, "Name of the vehicle. Default: the first.")
    size: str = option("1280x720", "Pixels.", metavar="WxH")
    fps: float = option(30.0, "Frames per second.", bounds=(1, 200, "Hz"))
    quality: str = option(
        "good",
        f"Pictures of which each frame is the mean: {', '.join(f'{name} {k}' for name, k in QUALITIES.items())}.",
        choices=tuple(QUALITIES),
    )
    from_s: float = option(0.0, "First simulated time [s].", bounds=(0, 1e6, "s"))
    until_s: float = option(3600.0, "Last simulated time [s].", bounds=(0.01, 1e6, "s"))

    def __post_init__(self) -> None:
        super().__post_init__()
        for pixels in self.pixels:
            require_within("--size", pixels, 1, MAX_PIXELS, "pixels")
        if not self.from_s < self.until_s:
            raise OptionError(f"--until = {self.until_s:g} s: must be above --from = {self.from_s:g} s")

    @property
    def pixels(self) -> tuple[int, int]:
        """The size as numbers. Raises OptionError."""
        text = self.size if isinstance(self.size, str) else "x".join(map(str, self.size))
        found = re.fullmatch(r"(\d{1,4})x(\d{1,4})", text)
        if found is None:
            raise OptionError(f"--size = {text[:40]}: must be WxH, such as 1920x1080")
        return int(found[1]), int(found[2])

    @property
    def carried_camera(self) -> str | None:
        """The name of the vehicle's camera that films, or None if another does."""
        return None if self.camera in ("chase", "orbit") or self.camera.endswith(".csv") else self.camera
