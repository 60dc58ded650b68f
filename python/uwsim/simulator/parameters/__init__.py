"""Parameters that can be changed during a run; their names and rules are those of the scenario."""

from uwsim.simulator.parameters.parameter import Parameter
from uwsim.simulator.parameters.parameters import Parameters, UnknownParameterError

__all__ = ["Parameter", "Parameters", "UnknownParameterError"]
