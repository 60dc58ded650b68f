"""A world in which vehicles use every kind of drive, for all-stop tests, and helpers that observe their motion."""

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
    """Write the scenario file. failsafe: YAML inserted into every vehicle."""
    path = folder / "drives.yaml"
    path.write_text(TEXT.replace("}}\n", f"}}, failsafe: {failsafe}}}\n" if failsafe else "}}\n") + more)
    return path


def at_rest(sim: Simulator) -> bool:
    """Return True if no thruster, fin or external force of any vehicle is commanded."""
    return not any(
        np.any(rov.effort) or any(t.command for t in rov.thrusters.values()) or any(rov.fins.values())
        for rov in sim.vehicles.values()
    )


def motion(sim: Simulator) -> bytes:
    """Return the exact poses and velocities of all vehicles, as bytes."""
    parts = [
        (rov.pose.world_from_body, rov.velocity.linear_body_m_s, rov.velocity.angular_body_rad_s)
        for rov in sim.vehicles.values()
    ]
    return b"".join(np.asarray(part).tobytes() for each in parts for part in each)
