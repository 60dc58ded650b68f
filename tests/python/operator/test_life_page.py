"""Fish and bubbles on the station's page and in Foxglove's scene: where they truly are, or not at all."""

from pathlib import Path

import numpy as np
import pytest

from browser import desk, until
from station_pages import serving
from uwsim.base.quaternions import turned
from uwsim.bridges.foxglove.life import level_turns, life
from uwsim.live import LiveSimulator
from uwsim.operator.station.scene.life import PERIOD_S
from uwsim.operator.station.sessions.description import describe
from uwsim.simulator.moving_shapes import MOST, swarm_places, swarms
from uwsim.simulator.simulator import Simulator

LIVELY = """
name: lively
terrain: {source: noise, size_m: [60, 60], bed_depth_m: 8}
obstacles:
  - {kind: pipeline, name: export, points_m: [[-10, 8], [10, 8]], radius_m: 0.3,
     condition: {features: [{kind: leak, at_m: 8, rate_l_min: 20}]}}
life:
  - {kind: school, name: sardine, count: 1500, size_m: [0.2, 0.3], position_m: [6, 4, -4], round_m: 4,
     spread_m: [3, 1.5, 0.8]}
vehicles:
  - {name: rov, model: rov, start: {position_m: [0, 0, -4], yaw_deg: 45}}
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("lively") / "lively.yaml"
    path.write_text(LIVELY)
    return path


def test_the_page_draws_them_where_they_are(browser, tmp_path: Path, scenario: Path) -> None:
    with desk(browser, tmp_path, str(scenario)) as here:
        page = here.fly()
        live = here.station.present().live
        live.pause()
        sim = live.simulator

        def agree() -> bool:
            found = [page.evaluate(f"station.life.placesOf('{name}')") for name in ("sardine", "export leak")]
            drawn = np.reshape(found[0] + found[1], (-1, 6))
            published_s = PERIOD_S * np.floor(sim.time_s / PERIOD_S + 1e-6)
            true = [np.hstack(sim.world.school_at(k, published_s))[:: one.every] for k, one in enumerate(swarms(sim))]
            return len(drawn) == sum(map(len, true)) and bool(np.allclose(drawn, np.vstack(true), atol=1e-3))

        until(agree, "the places of fish and bubbles")
        page.evaluate("station.views.enlarge('scene')")
        assert not here.complaints


def test_the_page_does_not_know_them_if_the_truth_is_hidden(scenario: Path) -> None:
    with serving(scenario.parent, is_fixed=True, truth=False) as (station, _):
        station.run(lambda: LiveSimulator(Simulator(scenario)))
        running = station.present()
        assert describe(running)["life"] is None
        assert not any(topic.name == "station/life" for topic in running.topics())


def test_however_many_there_are_few_are_drawn_and_all_look_ahead(scenario: Path) -> None:
    with Simulator(scenario) as sim:
        sim.advance(1.0)
        found = swarms(sim)
        assert [one.name for one in found] == ["sardine", "export leak"]
        places = swarm_places(sim, found)
        assert len(places) == sum(one.drawn for one in found) <= MOST
        assert np.allclose(places[: found[0].drawn, :3], sim.world.school_at(0, sim.time_s)[0][:: found[0].every])
        scene = life(found, places, sim.time_ns).encode()
        assert b"sardine" in scene and b"export leak" in scene
    for ahead, turn in zip(places[:, 3:], level_turns(places[:, 3:]), strict=True):
        along, left = turned(turn, np.eye(3)[:2])
        assert np.allclose(along, ahead) and left[2] == pytest.approx(0, abs=1e-12)
