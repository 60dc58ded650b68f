"""Vehicles with every kind of drive for tests of all stop, and measures of their motion."""

from pathlib import Path

import numpy as np

from uwsim import Simulator

DRIVES = ("thrusters", "fins", "forces")
TEXT = """
name: drives
terrain: {source: noise, size_m: [60, 60], bed_depth_m: 20}
vehicles:
  - {name: thrusters, model: bluerov2_heavy, start: {position_m: [0, 0, -5]}}
  - {name: fins, model: remus100, start: {position_m: [8, 0, -5]}}
  - {name: forces, model: rov, start: {position_m: [-8, 0, -5]}}
"""


def scenario(folder: Path, more: str = "", failsafe: str = "") -> Path:
    """Write the scenario; failsafe: of all vehicles, in YAML."""
    path = folder / "drives.yaml"
    path.write_text(TEXT.replace("}}\n", f"}}, failsafe: {failsafe}}}\n" if failsafe else "}}\n") + more)
    return path


def at_rest(sim: Simulator) -> bool:
    """Whether no thruster, fin or force of any vehicle is commanded."""
    return not any(
        np.any(rov.effort) or any(t.command for t in rov.thrusters.values()) or any(rov.fins.values())
        for rov in sim.vehicles.values()
    )


def motion(sim: Simulator) -> bytes:
    """Return where all vehicles are and how they move, to the last bit."""
    parts = [
        (rov.pose.world_from_body, rov.velocity.linear_body_m_s, rov.velocity.angular_body_rad_s)
        for rov in sim.vehicles.values()
    ]
    return b"".join(np.asarray(part).tobytes() for each in parts for part in each)
