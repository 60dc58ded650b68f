"""Prepares a simulator while the start screen is still open, so that it can start immediately."""

from __future__ import annotations

import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from uwsim.scenario import Scenario
from uwsim.scenario.fingerprint import scenario_fingerprint
from uwsim.simulator.simulator import Simulator

T = TypeVar("T")


def load_navigation() -> None:
    """Import the libraries of the estimate, which the panel would otherwise import between two steps."""
    import scipy.spatial.transform  # noqa: F401  # slow to import


class Prepared:
    """Holds at most one simulator, for the last validated choice. Choices are identified by scenario content.

    make: creates the simulator for a scenario. Methods may be called on any thread.
    """

    def __init__(self, make: Callable[[Scenario], Simulator]) -> None:
        self._make = make
        self._lock = threading.Lock()
        self._worker = ThreadPoolExecutor(1, "uwsim-prepare")
        self._key = ""
        self._made: Future[Simulator] | None = None

    def prepare(self, scenario: Scenario) -> None:
        """Start preparing a simulator, and discard any other scenario's. Raises OSError if a file is missing."""
        key = scenario_fingerprint(scenario)
        with self._lock:
            if key != self._key:
                self._drop()
                self._key, self._made = key, self._worker.submit(self._warm, scenario)

    def release(self, scenario: Scenario) -> Simulator:
        """Return the scenario's simulator, which is created now if it is not prepared.

        Raises the errors of `make`, and OSError.
        """
        key = scenario_fingerprint(scenario)
        with self._lock:
            made = self._made if self._key == key else None
            if made is None:
                self._drop()
            self._key, self._made = "", None
        if made is None or made.cancel():  # not started yet: it would have to wait for the previous one
            return self._make(scenario)
        return made.result()

    def afterwards(self, function: Callable[[], T]) -> T:
        """Call a function once all preparations have ended; return its result."""
        return self._worker.submit(function).result()

    def forget(self) -> None:
        """Discard the prepared simulator."""
        with self._lock:
            self._drop()

    def close(self) -> None:
        """Stop preparing simulators."""
        self.forget()
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _drop(self) -> None:
        if self._made is not None:
            self._made.cancel()
        self._key, self._made = "", None

    def _warm(self, scenario: Scenario) -> Simulator:
        """Create a simulator and render a small picture, since the first one is slow.

        This does not change the simulator's state.
        """
        load_navigation()
        simulator = self._make(scenario)
        for camera in list(simulator.rov.cameras.values())[:1]:
            camera.resized(64).capture().jpeg(80)
        return simulator
