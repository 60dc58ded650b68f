"""uwsim: a fast, headless underwater robotics simulator.

    import uwsim

    sim = uwsim.Simulator("lake", seed=7)     # or the path of a YAML file; uwsim.scenarios() lists the packaged ones
    rov = sim.rov                             # the first of sim.vehicles
    rov.undock()
    rov.set_effort(surge=0.5)                 # held until the next command
    sim.advance(2.0)                          # simulated seconds
    rov.pose, rov.telemetry()                 # where it is, what its panel shows
    rov.sensors["imu"].read()
    rov.sonar.ping().plot()
    rov.cameras["front"].capture().save("front.png")

See help(uwsim.Simulator) and help(type(rov)) for the rest.

World ENU, z up, water surface at z = 0; body x forward, y left, z up (REP 103); quaternions x, y, z, w; SI units.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from uwsim.base.extras import explain_missing_extras
from uwsim.base.no_collections import no_collections

if TYPE_CHECKING:
    from uwsim.batch import Batch
    from uwsim.campaigns.datasets import make_dataset
    from uwsim.campaigns.datasets.sequences import make_sequence
    from uwsim.evidence.identification import identify
    from uwsim.flight.fly import fly
    from uwsim.flight.survey import run_survey
    from uwsim.mapping import OccupancyMap
    from uwsim.operator.view import view
    from uwsim.scenario import Scenario, ScenarioError
    from uwsim.simulator.docking import DockedWarning
    from uwsim.simulator.simulator import Simulator

    __version__: str

explain_missing_extras()

# Imported on first use (PEP 562), so that `uwsim --help` responds immediately.
_MODULE_OF = {
    "Batch": "uwsim.batch",
    "DockedWarning": "uwsim.simulator.docking",
    "OccupancyMap": "uwsim.mapping",
    "Scenario": "uwsim.scenario",
    "ScenarioError": "uwsim.scenario",
    "Simulator": "uwsim.simulator.simulator",
    "fly": "uwsim.flight.fly",
    "identify": "uwsim.evidence.identification",
    "make_dataset": "uwsim.campaigns.datasets",
    "make_sequence": "uwsim.campaigns.datasets.sequences",
    "run_survey": "uwsim.flight.survey",
    "view": "uwsim.operator.view",
}

__all__ = [
    "Batch",
    "DockedWarning",
    "OccupancyMap",
    "Scenario",
    "ScenarioError",
    "Simulator",
    "__version__",
    "fly",
    "identify",
    "make_dataset",
    "make_sequence",
    "run_survey",
    "scenarios",
    "view",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return _version()
    if name not in _MODULE_OF:
        raise AttributeError(f"module 'uwsim' has no attribute '{name}'")
    with no_collections():
        value = getattr(import_module(_MODULE_OF[name]), name)
    globals()[name] = value
    return value


def _version() -> str:
    """Return the installed version. The import of importlib.metadata takes longer than all others here together."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version("uwsim")
    except PackageNotFoundError:  # running from a source tree that was never installed
        return "0+unknown"


def scenarios() -> list[str]:
    """Return the names of the packaged scenarios."""
    from uwsim.scenario import packaged_scenarios

    return list(packaged_scenarios())


def __dir__() -> list[str]:
    return sorted(__all__)
