"""Switch on the front lamps, take pictures ahead and down, and measure the height above the bed."""

import tempfile
from pathlib import Path

import numpy as np

import uwsim


def main() -> None:
    """Take pictures of the box in the pool in evening light."""
    sim = uwsim.Simulator("pool", seed=3)
    rov = sim.rov
    rov.place((0.0, 0.0, -3.0))
    sim.set_optics(jerlov="II", sun_elevation_deg=10)
    rov.lamps["front"].on = True
    ahead = rov.cameras["front"].capture()
    below = rov.cameras["down"].capture("off", geometry_only=True)
    path = Path(tempfile.gettempdir()) / "ahead.png"
    ahead.save(path)
    seen = sorted({ahead.label_names[k] for k in np.unique(ahead.labels)})
    print(f"{path}: {ahead.info.width} x {ahead.info.height} pixels; in sight: {', '.join(seen)}")
    print(f"the down camera is {np.median(below.depth_m):.2f} m above the bed")


if __name__ == "__main__":
    main()
