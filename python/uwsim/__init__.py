"""uwsim: a fast, headless underwater robotics simulator.

World ENU, z up, water surface at z = 0; body x forward, y left, z up (REP 103); quaternions x, y, z, w; SI units.
"""

from importlib.metadata import PackageNotFoundError, version

from uwsim.scenario import Scenario, ScenarioError
from uwsim.simulator import Simulator

try:
    __version__ = version("uwsim")
except PackageNotFoundError:  # a source tree that was never installed
    __version__ = "0+unknown"

__all__ = ["Scenario", "ScenarioError", "Simulator", "__version__"]
