"""What is wrong with a scenario's file, what it will look like, and what in it may surprise. `uwsim scenario check`."""

from uwsim.scenario_check.check import check_file
from uwsim.scenario_check.parts import check_part
from uwsim.scenario_check.report import CheckReport

__all__ = ["CheckReport", "check_file", "check_part"]
