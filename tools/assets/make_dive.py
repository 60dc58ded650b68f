"""Film docs/dive.webp, twelve seconds of a dive on the scenario `wreck`. Needs the built package."""

from __future__ import annotations

import math
import tempfile
from pathlib import Path

from uwsim.campaigns.film import make_film
from uwsim.missions import OwnVehicle, Steps, goto

OUT = Path(__file__).resolve().parents[2] / "docs" / "dive.webp"
FROM_S, LENGTH_S = 34.0, 12.0
WAY = ((-12, -16, -9), (-7, -10, -11.5), (-2.5, -7.5, -12), (8, -6.0, -11.5), (20, 0, -10))


def mission(vehicle: OwnVehicle) -> Steps[None]:
    """Fly past the break, and along the bow part."""
    vehicle.undock()
    for here, after in zip(WAY, (*WAY[1:], WAY[-1]), strict=True):
        heading = math.atan2(after[1] - here[1], after[0] - here[0]) if after != here else None
        yield from goto(vehicle, here, speed_m_s=0.8, within_m=0.8, heading_rad=heading)


def main() -> None:
    """Write the film."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / OUT.name
        make_film(
            __file__, made, scenario="wreck", size=(480, 270), fps=10.0, quality="good", from_s=FROM_S,
            until_s=FROM_S + LENGTH_S,
        )  # fmt: skip
        OUT.write_bytes(made.read_bytes())


if __name__ == "__main__":
    main()
