"""Loose bodies on the station's page and in Foxglove's scene: they are shown where they truly are, or not at all."""

import io
import json
from pathlib import Path

import numpy as np
import pytest
import shapely
from PIL import Image

from browser import desk, until
from station_pages import get, serving
from uwsim.base.quaternions import turned
from uwsim.bridges.foxglove.scenes import Bodies
from uwsim.live import LiveSimulator
from uwsim.operator.station.scene.loose_objects import outermost
from uwsim.operator.station.sessions.description import describe
from uwsim.operator.station.start.preview import OBSTACLE, draw
from uwsim.scenario import load
from uwsim.scenario.build.loose_bodies import object_mesh
from uwsim.simulator.simulator import Simulator

LOOSE = """
name: loose
terrain: {source: noise, size_m: [40, 40], bed_depth_m: 8}
vehicles:
  - {name: rov, model: rov, start: {position_m: [0, 0, -4]}}
objects:
  - shape: {kind: box, name: crate, position_m: [4, 1, -2], size_m: [0.6, 0.4, 0.4], yaw_pitch_roll_deg: [30, 20, 70]}
    density_kg_m3: 1400
  - {shape: {kind: sphere, name: ball, position_m: [8, 2, -7], radius_m: 0.3}, mass_kg: 20}
"""


@pytest.fixture(scope="module")
def scenario(tmp_path_factory):
    path = tmp_path_factory.mktemp("loose") / "loose.yaml"
    path.write_text(LOOSE)
    return path


def test_the_outermost_corners_have_the_shape_of_the_whole_body(scenario: Path) -> None:
    spec = load(scenario)
    for body in spec.objects:
        vertices, _ = object_mesh(spec, body)
        for turn in np.eye(4):
            whole, some = (
                shapely.convex_hull(shapely.multipoints(turned(turn, each)[:, :2]))
                for each in (vertices, outermost(vertices))
            )
            assert some.area == pytest.approx(whole.area, rel=0.02)


def test_the_page_does_not_know_bodies_if_the_truth_is_hidden(scenario: Path) -> None:
    with serving(scenario.parent, is_fixed=True, truth=False) as (station, server):
        station.run(lambda: LiveSimulator(Simulator(scenario)))
        assert describe(station.present())["objects"] is None
        assert json.loads(get(server, "/scene/scene.json")[1])["objects"] == []


def test_the_page_shows_bodies_where_they_are(browser, scenario: Path) -> None:
    with desk(browser, scenario.parent, str(scenario)) as here:
        page, live = here.fly(), here.station.present().live

        def agree() -> bool:
            found = {each["name"]: each["outline"] for each in page.evaluate("station.objects.outlines()")}
            return len(found) == 2 and all(
                np.allclose(np.mean(found[body.name], 0), body.pose.position_world_m[:2], atol=0.05)
                for body in live.simulator.objects.values()
            )

        until(agree, "the bodies' places, while one sinks and one rises")
        live.pause()
        until(agree, "the bodies' places")


def test_foxglove_gets_a_body_again_only_when_it_has_moved(scenario: Path) -> None:
    with Simulator(scenario) as sim:
        bodies = Bodies(sim.scenario)

        def poses():
            return {
                each.name: np.concatenate([each.pose.position_world_m, each.pose.orientation_xyzw])
                for each in sim.objects.values()
            }

        assert bodies.whole(0) is None
        first = bodies.moved(poses(), 0).encode()
        assert b"crate" in first and b"ball" in first and bodies.moved(poses(), 0) is None
        sim.advance(1.0)
        assert b"ball" in bodies.moved(poses(), sim.time_ns).encode()
        whole = bodies.whole(sim.time_ns).encode()
        assert b"crate" in whole and b"ball" in whole


def test_the_preview_has_bodies_at_their_start(scenario: Path) -> None:
    picture = np.asarray(Image.open(io.BytesIO(draw(load(scenario)))))
    rows, columns = np.nonzero(np.all(picture == OBSTACLE, axis=-1))
    per_m = picture.shape[1] / 40.0
    east_m, north_m = columns / per_m - 20.0, 20.0 - rows / per_m
    assert {(round(x / 4), round(y)) for x, y in zip(east_m, north_m, strict=True)} == {(1, 1), (2, 2)}
