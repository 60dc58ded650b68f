"""ArduSub in the loop: a compiled ArduPilot flies a simulated vehicle through its JSON interface."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.bridges.ardusub.ardusub import ArduSub, prepared

__all__ = ["ArduSub", "prepared"]
__getattr__ = lazy(__name__, dict.fromkeys(__all__, "ardusub"))
