"""A wall scan using only sonar: face the wall, keep a distance measured by the middle beams, and move up and down."""

import tempfile
from pathlib import Path

import numpy as np

import uwsim
from uwsim.missions import OwnVehicle, Steps, StoppedError, dive_to, turn_to, wait
from uwsim.scenario.read.assets import assets_folder

WALL = "\n  - {kind: box, name: wall, position_m: [7, 0, -2.5], size_m: [1, 14, 5]}"
DISTANCE_M, SPEED_M_S = 4.0, 0.25
LONGEST_S = 120.0
MIDDLE = 10  # beams on either side of the middle beam


def distance_m(vehicle: OwnVehicle) -> float:
    """Return the distance straight ahead: the median of the middle beams. Raises StoppedError if there is no wall."""
    ranges_m = np.asarray(vehicle.sonar.ping().ranges_m)
    ahead_m = ranges_m[len(ranges_m) // 2 - MIDDLE : len(ranges_m) // 2 + MIDDLE + 1]
    if not np.isfinite(ahead_m).any():
        raise StoppedError("there is no wall ahead")
    return float(np.median(ahead_m[np.isfinite(ahead_m)]))


def along_wall(vehicle: OwnVehicle, heading_rad: float, aside_m: float, z_m: float) -> Steps[None]:
    """Move sideways to port (starboard if negative) and to a height, facing the wall at DISTANCE_M."""
    ahead = np.array([np.cos(heading_rad), np.sin(heading_rad)])
    port = np.array([-ahead[1], ahead[0]])
    start_m = np.asarray(vehicle.pose.position_world_m)
    for _ in range(int(LONGEST_S / vehicle.autopilot.period_s)):
        position_m = np.asarray(vehicle.pose.position_world_m)
        left_m = aside_m - float((position_m - start_m)[:2] @ port)
        up_m = z_m - float(position_m[2])
        nearer_m = distance_m(vehicle) - DISTANCE_M
        if max(abs(left_m), abs(up_m), abs(nearer_m)) < 0.2:
            return
        to_wall = np.clip(0.5 * nearer_m, -SPEED_M_S, SPEED_M_S)
        sideways = np.clip(left_m, -SPEED_M_S, SPEED_M_S)
        climbed_m = float(np.clip(up_m, -0.4, 0.4))
        vehicle.autopilot.steer(heading_rad, to_wall * ahead + sideways * port, float(position_m[2]) + climbed_m)
        yield wait(vehicle.autopilot.period_s)
    raise StoppedError(f"stuck {left_m:.1f} m before the end of a pass")


def mission(vehicle: OwnVehicle) -> Steps[list[float]]:
    """Scan the wall to the east in three columns; return the distance measured at the end of each pass."""
    vehicle.undock()
    vehicle.sonar.aim(0.0)
    yield from dive_to(vehicle, 2.0)
    yield from turn_to(vehicle, 0.0)
    yield wait(6.0)  # time for the head to become level
    kept_m = []
    for aside_m, z_m in ((-3.0, -1.2), (0.0, -4.2), (3.0, -4.2), (0.0, -1.2), (3.0, -1.2), (0.0, -4.2)):
        yield from along_wall(vehicle, 0.0, aside_m, z_m)
        kept_m.append(distance_m(vehicle))
        vehicle.log("pass", distance_m=kept_m[-1])
    return kept_m


def main() -> None:
    """Fly the mission in the pool with an added wall."""
    text = (assets_folder() / "scenarios" / "pool.yaml").read_text()
    at = text.index("obstacles:") + len("obstacles:")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "wall.yaml"
        path.write_text(text[:at] + WALL + text[at:].replace("position_m: [3, 0, -4.5]", "position_m: [-8, 8, -4.5]"))
        flown = uwsim.fly(mission, path, map=True, voxel_m=0.2)
    assert flown.occupancy is not None and flown.result is not None, flown.ended_because
    voxels_m = flown.occupancy.occupied_voxels()
    face_m = voxels_m[np.abs(voxels_m[:, 0] - 6.5) < 0.25]
    seen = {(y, z) for _, y, z in np.floor(face_m / 0.2).astype(int).tolist() if -35 <= y < 35 and -25 <= z < 0}
    print(
        f"distance {np.mean(flown.result):.2f} m +- {np.std(flown.result):.2f} m in {flown.simulated_s:.0f} s, "
        f"{flown.collisions} collisions; {100 * len(seen) / (70 * 25):.0f} % of the wall's face is in the map"
    )


if __name__ == "__main__":
    main()
