"""How much there is to see in a scenario: features and gradients of pictures near its bed.

`python tools/look_measure.py [SCENARIO...]` takes 20 pictures of 256 x 256 pixels at fixed places from 1.2 to 3 m above
the bed of each, with the vehicle's nose 45 degrees down, by daylight, and prints the medians of: ORB keypoints (Rublee
et al. 2011, ICCV, at most 2000), the standard deviation of the brightness gradient [1 / pixel], and its kurtosis, which
is 3 for noise. Photographs of reefs have some 870 keypoints, 0.038 and 12. --out keeps the pictures.

What stays is the measure of how a camera can navigate: of the corners of a picture (Shi and Tomasi 1994), the share
that Lucas and Kanade's tracker finds within 1 pixel of their true place 0.1 s later, at 0.5 m/s. Light that moves over
the bed leads it astray; the same share without caustics shows by how much.
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
from uwsim.instruments.cameras import Camera, Frame
from uwsim.scenario import Scenario, load
from uwsim.scenario.read.validated import validated

OUTFITTED = "bluerov2_heavy_outfit"
"""The vehicle that takes the pictures where the scenario's own has no front camera."""
POSES, SIZE, PITCH_RAD = 20, 256, np.radians(45.0)
KEYPOINTS, DEVIATION, KURTOSIS = 300, 0.02, 7.0
"""The values that `reef` and `wreck` must exceed."""
APART_S, SPEED_M_S, NEAR_PX = 0.1, 0.5, 1.0
"""Between two pictures whose corners are tracked: time, speed, and how near a corner is the same."""
Pictures = Iterator[dict[str, tuple[Frame, Frame]]]


def main(
    scenarios: Annotated[list[str] | None, typer.Argument(help="Packaged names or files.")] = None,
    out: Annotated[Path | None, typer.Option(help="Folder for the pictures.")] = None,
    fine: Annotated[bool, typer.Option(help="With `detail: fine`.")] = False,
    turbid: Annotated[str, typer.Option(help="Jerlov's water type, such as 5C; the scenario's by default.")] = "",
) -> None:
    """Print the measure of each scenario."""
    for name in scenarios or ["reef", "wreck", "lake"]:
        found, tracks = [], {"as it is": (0, 0), "without caustics": (0, 0)}
        for k, pairs in enumerate(pictures(name, turbid, fine)):
            rgb = pairs["as it is"][0].rgb
            found.append(measured(rgb))
            tracks = {each: (kept + more, of + new) for each, (kept, of) in tracks.items()
                      for more, new in [tracked(*pairs[each])]}  # fmt: skip
            if out is not None:
                out.mkdir(parents=True, exist_ok=True)
                cv2.imwrite(str(out / f"{Path(name).stem}{turbid}-{k:02d}.png"), rgb[..., ::-1])
        keypoints, deviation, kurtosis = (statistics.median(column) for column in zip(*found, strict=True))
        rich = keypoints > KEYPOINTS and deviation > DEVIATION and kurtosis > KURTOSIS
        stays = ", ".join(f"{kept / max(of, 1):.2f} of {of} tracks stay {each}" for each, (kept, of) in tracks.items())
        print(f"{name}: {keypoints:.0f} keypoints, gradient deviation {deviation:.4f}, kurtosis {kurtosis:.1f}: "
              f"{'as' if rich else 'below'} a reef; {stays}")  # fmt: skip


def pictures(name: str, turbid: str, fine: bool = False) -> Pictures:
    """Yield the pictures of a scenario, each with the next one, as it is and without caustics."""
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
            shots: list[tuple[Frame, Frame]] = []
            for ahead_m in (0.0, APART_S * SPEED_M_S):
                sim.rov.place(np.array([x + ahead_m * np.cos(yaw), y + ahead_m * np.sin(yaw), z]), turn)
                shots.append((camera.capture(), camera.capture(without=("caustics", "shafts"))))
                sim.advance(APART_S)
            yield dict(zip(("as it is", "without caustics"), zip(*shots, strict=True), strict=True))


def _with_front_camera(scenario: Scenario, fine: bool) -> Scenario:
    """Return the scenario with a front camera on its first vehicle, which no tether and no link holds back."""
    first, *others = scenario.vehicles
    entry = {key: value for key, value in first.given().items() if key != "tether"}
    others_as_given = [vehicle.given() for vehicle in others]
    changed = {"vehicles": [entry, *others_as_given], "link": None} | ({"detail": "fine"} if fine else {})
    found = validated(Scenario, scenario.given() | changed)
    return found if "front" in first.model.cameras else found.with_changes(vehicle_model=OUTFITTED)


def tracked(first: Frame, second: Frame) -> tuple[int, int]:
    """Return how many corners are found in the next picture within NEAR_PX of their true place, and of how many."""
    one, two = (cv2.cvtColor(frame.rgb, cv2.COLOR_RGB2GRAY) for frame in (first, second))
    corners = cv2.goodFeaturesToTrack(one, 200, 0.01, 5)
    if corners is None:
        return 0, 0
    corners = corners.reshape(-1, 2)
    depth = first.depth_m[corners[:, 1].astype(int), corners[:, 0].astype(int)]
    corners, depth = corners[np.isfinite(depth)], depth[np.isfinite(depth)]
    if len(corners) == 0:
        return 0, 0
    k, distortion = np.asarray(first.info.k).reshape(3, 3), np.asarray(first.info.d)
    flat = cv2.undistortPoints(corners[:, None], k, distortion).reshape(-1, 2)
    points = np.column_stack([flat * depth[:, None], depth, np.ones(len(depth))]) @ first.world_from_optical.T
    seen = points @ np.linalg.inv(second.world_from_optical).T
    true = cv2.projectPoints(np.ascontiguousarray(seen[:, :3]), np.zeros(3), np.zeros(3), k, distortion)[0].reshape(
        -1, 2
    )
    inside = ((true > 0) & (true < SIZE - 1)).all(axis=1) & (seen[:, 2] > 0)
    found, status, _ = cv2.calcOpticalFlowPyrLK(one, two, corners[:, None].astype(np.float32), None, winSize=(21, 21))
    near = (status.ravel() == 1) & (np.linalg.norm(found.reshape(-1, 2) - true, axis=1) < NEAR_PX)
    return int((near & inside).sum()), int(inside.sum())


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
