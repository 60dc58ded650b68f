"""Onboard navigation of a simulated vehicle: a Navigator that starts when its estimate is first used."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import TYPE_CHECKING, Annotated, Any, ClassVar

import numpy as np
from pydantic import AfterValidator

from uwsim import _core
from uwsim.base.journal import Journal
from uwsim.base.named import require_names

if TYPE_CHECKING:
    from uwsim.navigation.estimation import Navigator, Start
    from uwsim.navigation.estimation.protocols import Instrumented
    from uwsim.navigation.estimation.saved import NavigatorState

KEPT_SAMPLES_S = 10.0  # longest interval between updates, which bounds the number of stored samples
ALIGNMENT_STD_M, ALIGNMENT_STD_M_S = 0.1, 0.05
"""Assumed accuracy of the initial position and velocity, as at a surveyed dock."""
LEVELS = 100  # depths at which the water's density is compared with the surface's
MIDDLE_PA = 5e6
GRAVITY_GROWTH_1_PA = 2.26e-7 / 1e4  # 2.26e-7 a metre, as in cpp/uwsim/world/water.cpp
MOVES = ("place", "dock", "undock")


class Use(IntEnum):
    """The ranks of those who use an estimate. What one computes from it does not depend on any of a lower rank.

    OBSERVER: recordings, pages, bridges and other readers. PROGRAM: a program that reads `Vehicle.estimate`. STEERING:
    holds, missions and bridges that steer by it.
    """

    OBSERVER = 0
    PROGRAM = 1
    STEERING = 2

    @classmethod
    def named(cls, name: str) -> Use:
        """Return the use with this name in lower case. Raises ValueError."""
        names = [use.name.lower() for use in cls]
        if name not in names:
            raise ValueError(f"start_navigation: use = {name!r:.60}: must be one of {', '.join(names)}")
        return cls(names.index(name))


def new_navigator(vehicle: Instrumented, start: Start, water: _core.Water) -> Navigator:
    """Create and start a Navigator for a vehicle in this water.

    Of the water, it receives what an operator has from a forecast and a chart: the surface's density, the waves'
    significant height, the largest height of the tide, but not its phase, and how much heavier than the surface the
    water is anywhere below and between which speeds of sound, but not where.
    """
    from uwsim.navigation.estimation import Navigator  # imported here: few simulators estimate

    surface_kg_m3 = float(water.density_at_kg_m3(0.0))
    heights_m = np.linspace(0.0, -water.bottom_depth_m, LEVELS)
    heavier_kg_m3 = max(abs(water.density_at_kg_m3(z_m) - surface_kg_m3) for z_m in heights_m.tolist())
    sound_m_s = [water.sound_speed_m_s(z_m) for z_m in heights_m.tolist()]
    return Navigator(
        vehicle,
        start,
        gravity_m_s2=water.gravity_m_s2,
        density_kg_m3=surface_kg_m3,
        compressibility_1_pa=_compressibility_1_pa(water),
        wave_std_m=0.0 if water.waves is None else 0.25 * water.waves.significant_height_m,
        tide_std_m=water.tide_bound_m / math.sqrt(2.0),
        column_std=heavier_kg_m3 / surface_kg_m3,
        sound_m_s=(min(sound_m_s), max(sound_m_s)),
    )


def _compressibility_1_pa(water: _core.Water) -> float:
    """Return that of the surface's water, in the middle of the upper 1,000 m, and what gravity's growth adds to it."""
    if not water.compressible:
        return 0.0
    state = water.temperature_deg_c(0.0), water.salinity_at_psu(0.0)
    squeezed = _core.sea_water_density_kg_m3(*state, MIDDLE_PA)
    return (1.0 - _core.sea_water_density_kg_m3(*state) / squeezed) / MIDDLE_PA + GRAVITY_GROWTH_1_PA


class OnboardNavigation:
    """One vehicle's Navigator, kept up to date as the simulator runs, and restarted when the vehicle is moved.

    It starts when the estimate is first used, since computing it takes longer than a step. A use of higher rank than
    all before starts it again at its own tick, so that a vehicle's flight does not depend on who has observed it.

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
        self._use = Use.OBSERVER
        self.due_tick = 0

    def begun(self, use: Use) -> Navigator:
        """Return the Navigator, started, if it has not been started for a use of this rank. Raises ValueError."""
        if self._navigator is None or use > self._use:
            self._begin(use)
        assert self._navigator is not None
        return self._navigator

    def _begin(self, use: Use) -> None:
        if self._navigator is None:
            self._navigator = self._make(self._start())
        else:
            self._navigator.become(lambda: self._make(self._start()))
        self._use = use
        self._attend()
        # in the journal, since a replay must start it at the same tick
        self._journal.note("start_navigation", vehicle=self._vehicle, use=use.name.lower())

    @property
    def shown(self) -> Navigator:
        """The Navigator, for observers of the vehicle."""
        return self.begun(Use.OBSERVER)

    @property
    def steering(self) -> Navigator:
        """The Navigator, for what steers the vehicle by its estimate."""
        return self.begun(Use.STEERING)

    def is_begun(self, use: Use) -> bool:
        """Return True if the Navigator has been started for a use of this rank."""
        return self._navigator is not None and use <= self._use

    def _attend(self) -> None:
        self.due_tick = self._tick() + self._every_ticks
        if self not in self._journal.observers:
            self._journal.attach(self, efforts=False)

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
        """Return the state of the Navigator and its use, or None if navigation has not begun."""
        return None if self._navigator is None else self._navigator.save(self._use.name.lower())

    def end(self) -> None:
        """Return to the state before navigation began: the next access starts another Navigator."""
        self._navigator = None
        self._use = Use.OBSERVER
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
        self._use = Use.named(_read(saved).use)
        self._attend()


def _read(text: str) -> NavigatorState:
    from uwsim.navigation.estimation.saved import NavigatorState  # imported here: few simulators estimate

    return NavigatorState.model_validate_json(text)


def _checked(text: str) -> str:
    _read(text)
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
