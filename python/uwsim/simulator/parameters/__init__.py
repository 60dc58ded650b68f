"""Parameters that can be changed during a run, with the names and rules of the scenario."""

from uwsim.simulator.parameters.parameter import Parameter
from uwsim.simulator.parameters.parameters import Parameters, UnknownParameterError

__all__ = ["Parameter", "Parameters", "UnknownParameterError"]
