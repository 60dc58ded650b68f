"""The peers suite: the same quantities computed by third-party libraries, where installed.

A peer is a module with `checks() -> list[Check]` and an entry in PEERS; `tethers` is the suite `tether` instead, and
`focused_light` in `camera`. The Python libraries can be installed with pip; uwsim does not depend on them.
"""

from __future__ import annotations

import warnings
from importlib import import_module
from importlib.metadata import version
from importlib.util import find_spec

from uwsim.evidence.validate.check import Check

PEERS = {
    "wave_loads": ("uwsim", "uwsim"),
    "added_mass": ("uwsim", "uwsim"),
    "lamp_light": ("uwsim", "uwsim"),
    "sea_water": ("gsw", "gsw"),
    "rigid_body": ("mujoco", "mujoco"),
    "pinhole": ("cv2", "opencv-python-headless"),
    "navigation": ("filterpy", "filterpy"),
    "daylight": ("pvlib", "pvlib"),
}
"""Python package and distribution of each peer; peers under `uwsim` have stored results or are linked with it."""


def run() -> list[Check]:
    """Return the checks against all installed peers; missing peers are skipped with a warning.

    Raises ValueError if none is installed.
    """
    found: list[Check] = []
    for name, (package, distribution) in PEERS.items():
        if find_spec(package) is None:
            warnings.warn(f"validate peers: {name} is left out: pip install {distribution}", stacklevel=2)
            continue
        found += import_module(f"{__name__}.{name}").checks()
    if not found:
        distributions = " ".join(distribution for _, distribution in PEERS.values())
        raise ValueError(f"validate peers: no peer is installed; pip install {distributions}")
    return found


def group(name: str) -> str:
    """Return a peer's name with its version, for the group of its checks."""
    package, distribution = PEERS[name]
    for installed in (distribution, package, "opencv-python"):
        try:
            return f"{package} {version(installed)}"
        except ModuleNotFoundError:
            continue
    return package
