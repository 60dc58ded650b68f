"""Onboard navigation of a simulated vehicle: a Navigator that starts when its estimate is first read."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

from pydantic import AfterValidator

from uwsim import _core
from uwsim.base.journal import Journal
from uwsim.base.named import require_names

if TYPE_CHECKING:
    from uwsim.navigation.estimation import Navigator, Start
    from uwsim.navigation.estimation.protocols import Instrumented

KEPT_SAMPLES_S = 10.0  # longest interval between updates, which bounds the number of stored samples
ALIGNMENT_STD_M, ALIGNMENT_STD_M_S = 0.1, 0.05
"""Assumed accuracy of the initial position and velocity, as at a surveyed dock."""
MOVES = ("place", "dock", "undock")


def new_navigator(
    vehicle: Instrumented, start: Start, water: _core.Water, station_world_m: tuple[float, float, float] | None
) -> Navigator:
    """Create and start a Navigator for a vehicle in this water.

    station_world_m: None for a station that moves, whose fixes are then not used. Of the waves, it receives the
    significant height, as in a forecast.
    """
    from uwsim.navigation.estimation import Navigator  # imported here: few simulators estimate

    return Navigator(
        vehicle,
        start,
        station_world_m=station_world_m,
        gravity_m_s2=water.gravity_m_s2,
        density_kg_m3=float(water.density_at_kg_m3(0.0)),
        wave_std_m=0.0 if water.waves is None else 0.25 * water.waves.significant_height_m,
    )


class OnboardNavigation:
    """One vehicle's Navigator, kept up to date as the simulator runs, and restarted when the vehicle is moved.

    make(start): creates the Navigator. start(): returns the current position and velocity and their accuracy.
    """

    def __init__(
        self,
        vehicle: str,
        journal: Journal,
        step_s: float,
        tick: Callable[[], int],
        make: Callable[[Start], Navigator],
        start: Callable[[], Start],
    ) -> None:
        self._vehicle, self._journal, self._tick = vehicle, journal, tick
        self._make, self._start = make, start
        self._every_ticks = max(round(KEPT_SAMPLES_S / step_s), 1)
        self._navigator: Navigator | None = None
        self.due_tick = 0

    @property
    def navigator(self) -> Navigator:
        """The Navigator; the first access starts it."""
        if self._navigator is None:
            self._navigator = self._make(self._start())
            self._attend()
            # in the journal, since a replay must start it at the same tick
            self._journal.note("start_navigation", vehicle=self._vehicle)
        return self._navigator

    def _attend(self) -> None:
        self.due_tick = self._tick() + self._every_ticks
        if self not in self._journal.observers:
            self._journal.attach(self, efforts=False)

    @property
    def has_begun(self) -> bool:
        """Whether the estimate has ever been read."""
        return self._navigator is not None

    def update(self) -> None:
        """Process new sensor samples if navigation has begun."""
        if self._navigator is not None:
            self._navigator.update()

    def observe(self) -> None:
        """Process new sensor samples, so that they do not accumulate."""
        self.update()
        self.due_tick = self._tick() + self._every_ticks

    def commanded(self, name: str, arguments: dict[str, Any]) -> None:
        """Restart from the new position if the command moved this vehicle; end a dock's hold if it released it."""
        if name in MOVES and arguments["vehicle"] == self._vehicle:
            self.restart()
        elif name == "release" and arguments["vehicle"] == self._vehicle and self._navigator is not None:
            self._navigator.release()

    def restart(self) -> None:
        """Restart from the current position and velocity if navigation has begun."""
        if self._navigator is not None:
            self._navigator.restart(self._start())
            self._attend()

    def save(self) -> str | None:
        """Return the Navigator's state, or None if navigation has not begun."""
        return None if self._navigator is None else self._navigator.save()

    def end(self) -> None:
        """Return to the state before navigation began: the next access starts another Navigator."""
        self._navigator = None
        self.due_tick = 0
        self._journal.detach(self)

    def restore(self, saved: str | None) -> None:
        """Continue from a saved state; None means that navigation had not begun. Raises ValueError."""
        if saved is None:
            self.end()
            return
        if self._navigator is None:
            self._navigator = self._make(self._start())
        self._navigator.restore(saved)
        self._attend()


def _checked(text: str) -> str:
    from uwsim.navigation.estimation.saved import NavigatorState  # imported here: few simulators estimate

    NavigatorState.model_validate_json(text)
    return text


class Estimates:
    """Part of a saved state: the estimates of all vehicles whose navigation has begun, by vehicle."""

    STATE: ClassVar[Any] = dict[str, Annotated[str, AfterValidator(_checked)]]

    def __init__(self, navigations: Mapping[str, OnboardNavigation]) -> None:
        self._navigations = navigations

    def save(self) -> dict[str, str]:
        """Return the state as JSON values."""
        states = {name: navigation.save() for name, navigation in self._navigations.items()}
        return {name: state for name, state in states.items() if state is not None}

    def restore(self, state: Mapping[str, str]) -> None:
        """Load a state returned by `save`. Raises ValueError if it belongs to other vehicles."""
        require_names("estimates", {**self._navigations, **state}, self._navigations)
        for name, navigation in self._navigations.items():
            navigation.restore(state.get(name))
