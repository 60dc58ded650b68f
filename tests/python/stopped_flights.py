"""Flights that are saved and stopped at chosen pauses, as by autosaves and Ctrl-C."""

from uwsim.flight.autosave import FlightAutosave


class StopAfter(FlightAutosave):
    """Save a flight at the given pauses, counted from 1, and stop it at the last."""

    def __init__(self, *pauses: int) -> None:
        super().__init__(1e6)
        self.pauses, self.count = pauses, 0

    def due(self) -> bool:
        return self.count in self.pauses

    def stop_requested(self) -> bool:
        self.count += 1
        return self.count >= self.pauses[-1]
