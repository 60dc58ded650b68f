"""How much there is to see in a scenario: features and gradients of pictures near its bed.

`python tools/look_measure.py [SCENARIO...]` takes 20 pictures of 256 x 256 pixels at fixed places from 1.2 to 3 m above
the bed of each, with the vehicle's nose 45 degrees down, by daylight, and prints the medians of: ORB keypoints (Rublee
et al. 2011, ICCV, at most 2000), the standard deviation of the brightness gradient [1 / pixel], and its kurtosis, which
is 3 for noise. Photographs of reefs have some 870 keypoints, 0.038 and 12. --out keeps the pictures.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated

import cv2
import numpy as np
import typer
from numpy.typing import NDArray

import uwsim
from uwsim.instruments.cameras import Camera
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.validated import validated

OUTFITTED = "bluerov2_heavy_outfit"
"""The vehicle that takes the pictures where the scenario's own has no front camera."""
POSES, SIZE, PITCH_RAD = 20, 256, np.radians(45.0)
KEYPOINTS, DEVIATION, KURTOSIS = 300, 0.02, 7.0
"""The values that `reef` and `wreck` must exceed."""
Pictures = Iterator[NDArray[np.uint8]]


def main(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Packaged names or files.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the pictures.")] = None,
    fine: Annotated[bool, typer.Option(help="With `detail: fine`.")] = False,
    turbid: Annotated[str, typer.Option(help="Jerlov's water type, such as 5C; the scenario's by default.")] = "",
) -> None:
    """Print the measure of each scenario."""
    for name in scenarios or ["reef", "wreck", "lake"]:
        found = []
        for k, rgb in enumerate(pictures(name, turbid, fine)):
            found.append(measured(rgb))
            if out is not None:
                out.mkdir(parents=True, exist_ok=True)
                cv2.imwrite(str(out / f"{Path(name).stem}{turbid}-{k:02d}.png"), rgb[..., ::-1])
        keypoints, deviation, kurtosis = (statistics.median(column) for column in zip(*found, strict=True))
        rich = keypoints > KEYPOINTS and deviation > DEVIATION and kurtosis > KURTOSIS
        print(f"{name}: {keypoints:.0f} keypoints, gradient deviation {deviation:.4f}, kurtosis {kurtosis:.1f}: "
              f"{'as' if rich else 'below'} a reef")  # fmt: skip


def pictures(name: str, turbid: str, fine: bool = False) -> Pictures:
    """Yield the pictures of a scenario."""
    random = np.random.default_rng(54)
    with uwsim.Simulator(_with_front_camera(load(name), fine)) as sim:
        sim.rov.release()
        if turbid:
            sim.set_optics(jerlov=turbid)
        camera: Camera = sim.rov.cameras["front"].resized(SIZE, SIZE)
        x0, y0, x1, y1 = sim.world.terrain_extent_m
        taken = 0
        while taken < POSES:
            x, y = random.uniform((0.7 * x0, 0.7 * y0), (0.7 * x1, 0.7 * y1))
            height, yaw = random.uniform(1.2, 3.0), random.uniform(0, 2 * np.pi)
            z = float(sim.world.height_at([[x, y]])[0]) + height
            if z > -0.5 or sim.world.solid_around([x, y, z]) is not None:
                continue
            taken += 1
            half = 0.5 * PITCH_RAD
            turn = np.array([-np.sin(yaw / 2) * np.sin(half), np.cos(yaw / 2) * np.sin(half),
                             np.sin(yaw / 2) * np.cos(half), np.cos(yaw / 2) * np.cos(half)])  # fmt: skip
            sim.rov.place(np.array([x, y, z]), turn)
            yield camera.capture().rgb


def _with_front_camera(scenario: Scenario, fine: bool) -> Scenario:
    """Return the scenario with a front camera on its first vehicle, which no tether and no link holds back."""
    first, *others = scenario.vehicles
    entry = {key: value for key, value in first.given().items() if key != "tether"}
    others_as_given = [vehicle.given() for vehicle in others]
    changed = {"vehicles": [entry, *others_as_given], "link": None} | ({"detail": "fine"} if fine else {})
    found = validated(Scenario, scenario.given() | changed)
    return found if "front" in first.model.cameras else found.with_changes(vehicle_model=OUTFITTED)


def measured(rgb: NDArray[np.uint8]) -> tuple[int, float, float]:
    """Return keypoints, and the deviation and kurtosis of the gradient of brightness in [0, 1]."""
    grey = cv2.cvtColor(rgb, cv2.COLOR_RGB2GRAY)
    keypoints = cv2.ORB_create(nfeatures=2000).detect(grey)
    bright = grey.astype(np.float64) / 255
    slopes = np.concatenate([np.diff(bright, axis=0).ravel(), np.diff(bright, axis=1).ravel()])
    deviation = float(slopes.std())
    return len(keypoints), deviation, float(((slopes - slopes.mean()) ** 4).mean() / max(deviation, 1e-9) ** 4)


if __name__ == "__main__":
    typer.run(main)
