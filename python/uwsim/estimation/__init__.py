"""Navigation by a vehicle's own instruments: an error-state Kalman filter. It sees vehicles through protocols only."""

from uwsim.estimation.navigator import Navigator
from uwsim.estimation.start import Start

__all__ = ["Navigator", "Start"]
