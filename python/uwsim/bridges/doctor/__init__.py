"""`uwsim doctor`: finds out why uwsim and other programs do not see each other, and suggests remedies."""

from uwsim.bridges.doctor.examine import Plan, examine
from uwsim.bridges.doctor.finding import Finding, Verdict

__all__ = ["Finding", "Plan", "Verdict", "examine"]
