"""Parameters that can be changed while a simulator runs, with the scenario's names and rules."""

from uwsim.simulator.parameters.parameter import Parameter
from uwsim.simulator.parameters.parameters import Parameters, UnknownParameterError

__all__ = ["Parameter", "Parameters", "UnknownParameterError"]
