"""A digital twin: poorly mapped parts are surveyed again, the vehicle docks, and a second visit finds changes."""

import tempfile
from pathlib import Path

import uwsim
from uwsim.mapping.changes import map_changes
from uwsim.missions import OwnVehicle, Steps
from uwsim.missions.planners.twin import Twin, make_twin
from uwsim.scenario.read.assets import assets_folder

AREA_M = [[-16, -20], [4, -20], [4, -8], [-16, -8]]
LOST_CARGO = "\n  - {kind: box, name: cargo, position_m: [-4, -14, -8], size_m: [2, 1.5, 2]}"


def mission(vehicle: OwnVehicle) -> Steps[Twin]:
    """Build a digital twin of the area, return, and dock."""
    return (yield from make_twin(vehicle, AREA_M))


def main() -> None:
    """Visit the cove twice; cargo is lost between the visits."""
    first = uwsim.fly(mission, "cove").result
    cove = (assets_folder() / "scenarios" / "cove.yaml").read_text()
    with tempfile.TemporaryDirectory() as folder:
        later = Path(folder) / "later.yaml"
        later.write_text(cove.replace("\nobstacles:", "\nobstacles:" + LOST_CARGO))
        second = uwsim.fly(mission, later).result
    print(
        f"weak columns: {100 * first.weak_before:.1f} %, after {first.patches} patches {100 * first.weak_after:.1f} %; "
        f"docked: {first.docked}"
    )
    for change in map_changes(first.map, second.map):
        east, north, up = change.middle_world_m
        print(f"{change.kind}: {len(change.voxels_m)} voxels about ({east:.1f}, {north:.1f}, {up:.1f}) m")


if __name__ == "__main__":
    main()
