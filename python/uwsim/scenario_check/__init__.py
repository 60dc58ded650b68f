"""What is wrong with a scenario's file, what it will look like, and what in it may surprise. `uwsim scenario check`."""

from uwsim.scenario_check.check import CheckReport, check_file, check_part

__all__ = ["CheckReport", "check_file", "check_part"]
