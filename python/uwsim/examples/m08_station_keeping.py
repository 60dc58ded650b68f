"""Station keeping in a gusty current of 0.5 m/s, using only the vehicle's own instruments."""

import tempfile
from pathlib import Path

import numpy as np

import uwsim
from uwsim.missions import Steps, Vehicle, goto, hold
from uwsim.scenario.read.assets import assets_folder

PLACE_M = (0.0, 0.0, -5.0)
CURRENT = """
  current:
    kind: gusts
    mean_m_s: [0.4, 0.3, 0]
    sigma_m_s: [0.14, 0.14, 0]
    correlation_time_s: 10
"""


def mission(vehicle: Vehicle) -> Steps[None]:
    """Go to a position and stay there for a minute."""
    yield from goto(vehicle, PLACE_M)
    vehicle.log("there")
    yield from hold(vehicle, 60.0, position_world_m=PLACE_M)


def main() -> None:
    """Fly the mission with the BlueROV2 Heavy of the packaged scenario `pair`, with an added current."""
    text = (assets_folder() / "scenarios" / "pair.yaml").read_text().replace("water:\n", "water:" + CURRENT)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "gusts.yaml"
        path.write_text(text)
        flown = uwsim.fly(mission, path, vehicles=["scout"], estimate="filter")
    there_s = next(event.time_s for event in flown.events if event.name == "there")
    samples = flown.samples["scout"]
    off_m = np.linalg.norm(samples.path_world_m - PLACE_M, axis=1)[samples["time_s"] > there_s + 10.0]
    print(f"{np.sqrt((off_m**2).mean()):.2f} m RMS from its place, {off_m.max():.2f} m at most, for a minute")


if __name__ == "__main__":
    main()
