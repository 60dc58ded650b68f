"""The simulator: steps, vehicles, parameters, failures and docking."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from uwsim.simulator.simulator import Simulator

__all__ = ["Simulator"]


def __getattr__(name: str) -> Any:  # lazy, since the modules of this package import each other through it
    if name != "Simulator":
        raise AttributeError(f"module 'uwsim.simulator' has no attribute '{name}'")
    from uwsim.simulator.simulator import Simulator

    return Simulator
