"""Parameters that may be changed while a simulator runs: named as in the scenario, checked as there."""

from uwsim.parameters.parameter import Parameter
from uwsim.parameters.parameters import Parameters, UnknownParameterError

__all__ = ["Parameter", "Parameters", "UnknownParameterError"]
