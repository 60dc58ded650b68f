"""`uwsim ros doctor`: diagnoses why uwsim and other programs cannot see each other, and suggests remedies."""

from uwsim.bridges.doctor.examine import examine
from uwsim.bridges.doctor.finding import Finding, Verdict

__all__ = ["Finding", "Verdict", "examine"]
