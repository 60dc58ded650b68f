"""`uwsim doctor`: finds out what prevents two sides from seeing each other, and suggests a remedy."""

from uwsim.bridges.doctor.examine import Plan, examine
from uwsim.bridges.doctor.finding import Finding, Verdict

__all__ = ["Finding", "Plan", "Verdict", "examine"]
