"""Puts an edited scenario into the paused simulator of a session, in a new one: vehicles, time and maps are kept."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

from uwsim.live import LiveSimulator
from uwsim.operator.station.sessions.running import Running
from uwsim.operator.station.sessions.saves import continue_maps
from uwsim.operator.station.sessions.sessions import Sessions
from uwsim.operator.station.start.choice import ChoiceError, with_choice
from uwsim.scenario import Scenario
from uwsim.simulator.simulator import Simulator

SAME = "it needs the same vehicles, with the same parts: save the scenario, and start it"


def rebuild(sessions: Sessions, edited: Scenario) -> None:
    """Continue with an edited scenario, to which the choice made on the start screen applies, too.

    Efforts are zero at first. Raises ScenarioError, ChoiceError or ValueError; the present simulator then stays.
    """
    running, choice = sessions.present(), sessions.choice
    if reason := _hindrance(running):
        raise ValueError(f"the world cannot be rebuilt: {reason}")
    errors: dict[str, str] = {}
    scenario = with_choice(edited, choice, errors)
    if errors:
        raise ChoiceError(errors)
    live = running.live

    def make() -> LiveSimulator:
        sim = Simulator(scenario, threads=sessions.threads)
        try:
            live.read(sim.take_over).result()
        except ValueError as error:
            raise ValueError(f"the world cannot be rebuilt: {error}; {SAME}") from None
        for vehicle in sim.vehicles.values():
            if (name := sim.world.solid_around(vehicle.pose.position_world_m)) is not None:
                raise ValueError(f"the world cannot be rebuilt: vehicle '{vehicle.name}' would be inside '{name}'")
            vehicle.set_effort()
        return LiveSimulator(sim, speed=live.speed, paused=True)

    with TemporaryDirectory() as folder:
        for name, ping_map in running.maps.items():
            ping_map.write(Path(folder) / f"{name}.ot")
        sessions.run(make, lambda rebuilt: continue_maps(rebuilt, Path(folder)), choice=choice)
    for name, vehicle in live.simulator.vehicles.items():
        if vehicle.helm.all_stopped:  # perhaps since the state was taken over
            sessions.present().live.command("all_stop", vehicle=name, on=True).result()


def _hindrance(running: Running) -> str:
    if running.replay is not None:
        return "a flight is replayed"
    if running.judged is not None:
        return "an exercise is flown"
    if running.rosbridge is not None:
        return "it has joined your rosbridge"
    return "" if running.live.paused else "it runs: pause it first"
