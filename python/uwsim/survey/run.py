"""An alias of uwsim.flight.survey, for one version."""

from uwsim.flight.survey import resume_survey as resume_survey
from uwsim.flight.survey import run_survey as run_survey
