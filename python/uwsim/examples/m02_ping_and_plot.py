"""Sonar pings: turn on the spot, ping in all directions, and plot the echoes from above."""

import math
import tempfile
from pathlib import Path

import numpy as np

import uwsim
from uwsim.figures.style import HEIGHTS, label_axes, new_figure, save_figure
from uwsim.missions import OwnVehicle, Steps, dive_to, turn_to, wait


def mission(vehicle: OwnVehicle) -> Steps[np.ndarray]:
    """Ping at eight headings; return the echoes' positions in the world, (n, 3)."""
    vehicle.undock()
    vehicle.sonar.aim(math.radians(-35.0))
    yield from dive_to(vehicle, 15.0)
    echoes = []
    for heading_rad in np.radians(np.arange(0.0, 360.0, 45.0)):
        yield from turn_to(vehicle, heading_rad)
        yield wait(0.1)
        ping = vehicle.sonar.ping()
        here = ping.points_sonar_m[np.isfinite(ping.ranges_m)]
        echoes.append(here @ ping.world_from_sonar[:3, :3].T + ping.world_from_sonar[:3, 3])
        vehicle.log("ping", heading_deg=math.degrees(heading_rad), echoes=len(here))
    return np.concatenate(echoes)


def plot(path: Path, echoes_m: np.ndarray) -> None:
    """Plot echoes from above, coloured by height."""
    figure = new_figure(6.0, 6.0)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    label_axes(axes, "Echoes of eight pings", "east [m]", "north [m]")
    axes.scatter(echoes_m[:, 0], echoes_m[:, 1], c=echoes_m[:, 2], s=2, cmap=HEIGHTS)
    axes.set_aspect("equal")
    save_figure(figure, path)


def main() -> None:
    """Fly the mission in the lake, and plot the echoes."""
    echoes_m = uwsim.fly(mission, "lake").result
    path = Path(tempfile.gettempdir()) / "echoes.png"
    plot(path, echoes_m)
    print(f"{len(echoes_m)} echoes, the highest at {echoes_m[:, 2].max():.1f} m, drawn in {path}")


if __name__ == "__main__":
    main()
