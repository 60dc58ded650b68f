"""Checks of scenario files: mistakes, likely oversights, and a description of the scene (`uwsim scenario check`)."""

from uwsim.evidence.scenario_check.check import check_file
from uwsim.evidence.scenario_check.parts import check_part
from uwsim.evidence.scenario_check.report import CheckReport

__all__ = ["CheckReport", "check_file", "check_part"]
