"""uwsim: a fast, headless underwater robotics simulator.

World ENU, z up, water surface at z = 0; body x forward, y left, z up (REP 103); quaternions x, y, z, w; SI units.
"""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from uwsim.docking import DockedWarning
    from uwsim.flight.fly import fly
    from uwsim.scenario import Scenario, ScenarioError
    from uwsim.simulator import Simulator

try:
    __version__ = version("uwsim")
except PackageNotFoundError:  # a source tree that was never installed
    __version__ = "0+unknown"

# Imported on first use (PEP 562), so that `uwsim --help` answers at once.
_MODULE_OF = {
    "DockedWarning": "uwsim.docking",
    "Scenario": "uwsim.scenario",
    "ScenarioError": "uwsim.scenario",
    "Simulator": "uwsim.simulator",
    "fly": "uwsim.flight.fly",
}

__all__ = ["DockedWarning", "Scenario", "ScenarioError", "Simulator", "__version__", "fly"]


def __getattr__(name: str) -> Any:
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'uwsim' has no attribute '{name}'")
    value = getattr(import_module(_MODULE_OF[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
