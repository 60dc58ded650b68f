"""Navigation by a vehicle's own instruments: an error-state Kalman filter that sees vehicles only through protocols."""

from uwsim.navigation.estimation.navigator import Navigator
from uwsim.navigation.estimation.start import Start

__all__ = ["Navigator", "Start"]
