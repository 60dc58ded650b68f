"""A lawn-mower saved in flight and flown on from there, as its tests by vehicle and scenario share it."""

import json
from collections.abc import Callable

from uwsim import Simulator
from uwsim.missions import AdaptiveLawnMower, LawnMowerPlan

When = Callable[[AdaptiveLawnMower, Simulator], bool]


def mow_twice(
    simulator: Callable[[], Simulator], plan: LawnMowerPlan, saves: When, ends: When = lambda mission, sim: False
) -> AdaptiveLawnMower:
    """Fly whole, saved where `saves` is first true, and on from there: to the last bit the same. Return the first."""
    saved: list[tuple[str, bytes]] = []

    def flown() -> tuple[AdaptiveLawnMower, bytes]:
        with simulator() as sim:
            mission = AdaptiveLawnMower(sim.rov, sim, plan)
            if saved:
                mission.restore(json.loads(saved[0][0]))
                sim.restore_state(saved[0][1])
            for wait in mission.steps():
                sim.wait(wait.duration_s)
                if not saved and saves(mission, sim):
                    saved.append((json.dumps(mission.save()), sim.save_state()))
                if ends(mission, sim):
                    break
            return mission, sim.save_state()

    (first, whole), (_, again) = flown(), flown()
    assert saved and again == whole
    return first
