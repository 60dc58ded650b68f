"""An alias of uwsim.flight.record, for one version."""

from uwsim.flight.record import FlightRecord as SurveyRecord

__all__ = ["SurveyRecord"]
