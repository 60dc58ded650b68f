"""`uwsim doctor`: looks for what keeps two sides from seeing each other, and says what to do."""

from uwsim.doctor.examine import Plan, examine
from uwsim.doctor.finding import Finding, Verdict

__all__ = ["Finding", "Plan", "Verdict", "examine"]
