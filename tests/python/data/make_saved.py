"""Write files with this build that later builds must be able to read; tests/python/data/v1 was created with it.

    python tests/python/data/make_saved.py /srv/v1

Run it only after raising a format's version, and store its output next to v1. The files contain the folder's name.
"""

import os
import shutil
import sys
from pathlib import Path

from uwsim import Simulator
from uwsim.flight.autosave import FlightAutosave
from uwsim.flight.fly import fly
from uwsim.flight.survey import run_survey
from uwsim.mapping import OccupancyMap
from uwsim.recording import Recorder
from uwsim.scenario import load
from uwsim.scenario.dump import write_scenario

SCENARIO, SEED = "scenario.yaml", 5
MISSION = """from uwsim.missions import wait


def mission(vehicle):
    vehicle.release()
    vehicle.set_effort(surge=0.3)
    for _ in range(20):
        yield wait(0.5)
"""


class StopAt(FlightAutosave):
    """Ask the flight to stop at a given pause, and save it there."""

    def __init__(self, pause: int) -> None:
        super().__init__(1e6)
        self.left = pause

    def due(self) -> bool:
        """Return True if a save is due."""
        return False

    def stop_requested(self) -> bool:
        """Return True once that pause is reached."""
        self.left -= 1
        return self.left <= 0


def main(folder: Path) -> None:
    """Write one file of each format."""
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    pool = load("pool").with_changes(seed=SEED)
    mesh = pool.vehicles[0].model.mesh
    Path(mesh.name).write_bytes(mesh.read_bytes())
    write_scenario(Path(SCENARIO), pool)
    Path(SCENARIO).write_text(Path(SCENARIO).read_text().replace(str(mesh), mesh.name))
    sim = Simulator(SCENARIO)
    sim.rov.release()
    sim.rov.set_effort(surge=0.6, yaw=-0.2)
    sim.advance(2.0)
    Path("simulator.state").write_bytes(sim.save_state())
    sim = Simulator(SCENARIO)
    sim.rov.undock()
    _ = sim.rov.estimate  # the first access starts the filter
    sim.rov.set_effort(surge=0.6)
    sim.advance(2.0)
    Path("estimate.state").write_bytes(sim.save_state())
    fly(None, SCENARIO, "survey", map=True, report="none", autosave=StopAt(60))
    Path("mission.py").write_text(MISSION)
    fly("mission.py", SCENARIO, "flight", map=True, report="none", autosave=StopAt(20))
    with Simulator(SCENARIO) as live, Recorder(live, "live.mcap", topics=["odom", "imu*", "telemetry", "ping"]):
        live.rov.release()
        live.rov.set_effort(surge=0.4)
        live.advance(1.0)
    run_survey(
        SCENARIO, "recorded", mission_time_s=3.0, report="none", autosave_s=0.0,
        record=Path("survey.mcap"), record_topics=("odom",),
    )  # fmt: skip
    OccupancyMap.read("recorded/map.bt").write("map.ot")
    run_survey(SCENARIO, "scored", mission_time_s=2.0, report="none", autosave_s=0.0)
    Path("scored/track.npz").rename("track.npz")
    for done in ("scored", "recorded"):
        shutil.rmtree(done)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
