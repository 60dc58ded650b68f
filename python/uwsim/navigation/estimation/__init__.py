"""Navigation by onboard instruments: an error-state Kalman filter that accesses vehicles only through protocols."""

from uwsim.navigation.estimation.navigator import Navigator
from uwsim.navigation.estimation.saved import Start

__all__ = ["Navigator", "Start"]
