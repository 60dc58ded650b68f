"""The paper's figures, reproduced: pictures and their underlying values, transform trees, and maps per message type."""

import json
import re
import sys

import numpy as np
import pytest
from PIL import Image

from command_line import error_line, uwsim
from uwsim.evidence.reproduce import graphs, movement_and_ray, mown_map, paper, scenes, screens, sonar
from uwsim.scenario import load
from uwsim.simulator.simulator import Simulator


@pytest.fixture(scope="module")
def sim():
    return Simulator(scenes.with_cameras(load("paper"), overview=scenes.OVERVIEW, beside=sonar.BESIDE))


def picture(path):
    pixels = np.asarray(Image.open(path).convert("L"), int)
    assert min(pixels.shape) > 100
    return pixels


def test_the_transform_tree_has_the_published_frames_and_the_standard_topics(sim, tmp_path):
    rows = graphs.transform_tree(sim, tmp_path / "tree.png").rows
    assert [row[1:] for row in rows if row[0] == "published"] == [
        ("odom", "base_footprint", 50.0), ("base_footprint", "base_scan", 50.0)
    ]  # fmt: skip
    assert {("standard", "odom", "base_footprint", 50.0), ("standard", "map", "odom", "static")} <= {*rows}
    assert picture(tmp_path / "tree.png").std() > 10


def test_the_node_map_joins_the_simulator_to_the_published_chain(sim, tmp_path):
    rows = {*graphs.node_map(sim, tmp_path / "map.png").rows}
    assert rows >= {
        ("simulator", "depthArray", "stringDecoder"), ("stringDecoder", "decodedDepth", "Laser_Scan_Publisher"),
        ("Laser_Scan_Publisher", "scan", "laser2PointCloud"), ("laser2PointCloud", "laserPointCloud", "octomap_server"),
        ("simulator", "propPos", "AUV_Pose_Broadcaster"), ("AUV_Pose_Broadcaster", "tf", "octomap_server"),
        ("simulator", "stateData", "paraPublisher"), ("LawnMower", "key", "simulator"),
    }  # fmt: skip
    assert {topic for _, topic, reader in rows if reader == "none"} == {
        "image/compressed", "images/compressed", "rovParameters", "octomap_binary"
    }  # fmt: skip
    assert picture(tmp_path / "map.png").std() > 10


def test_what_lies_under_water_is_seen_nearer_to_the_eye_by_the_law_of_refraction():
    eye, point = np.array([0.0, 0.0, 10.0]), np.array([[20.0, 0.0, -15.0], [20.0, 0.0, 3.0]])
    through, above = scenes.apparent(eye, point)
    up, down = through[0] / np.hypot(through[0], 10.0), (20.0 - through[0]) / np.hypot(20.0 - through[0], 15.0)
    assert up == pytest.approx(scenes.WATER_INDEX * down, rel=1e-6)
    assert (through[2], *above) == (0.0, *point[1])


def test_the_screens_are_our_stations_page_in_a_browser(sim, tmp_path):
    """Takes 10 s, most of it until a real page has drawn a flight."""
    start, main = screens.screens(sim, tmp_path)
    assert "Taken now" in start.caption and "Taken now" in main.caption
    assert dict(main.rows)["proximity warning"] is True
    pixels = np.asarray(Image.open(tmp_path / "fig05.png").convert("RGB"), int)
    amber = (np.abs(pixels - (255, 194, 71)).max(axis=-1) < 25)[200:450, 1030:1120]
    assert amber.sum() > 100  # the altitude on its tape
    assert picture(tmp_path / "fig04.png").std() > 10


def test_without_a_browser_the_kept_screens_are_drawn(sim, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "playwright.sync_api", None)
    figures = screens.screens(sim, tmp_path)
    assert all("A kept picture: Playwright is not installed" in figure.caption for figure in figures)
    assert [picture(tmp_path / f"{figure.name}.png").shape for figure in figures] == [(1470, 1280), (900, 1440)]


def test_every_cell_of_the_table_is_compared_with_its_printed_value(tmp_path):
    figure = sonar.coverage(tmp_path / "fig08.png")
    columns = [row[0] for row in figure.rows]
    assert (columns.count("depth"), columns.count("coverage")) == (20, 32)
    assert all(row[5] > 0 and abs(row[-1]) < 10 for row in figure.rows)
    two_receivers = [row[5] for row in figure.rows if row[4] == 2]
    assert two_receivers == [980, 760, 430, 2110, 1270, 610, 930, 725, 410, 2000, 1200, 570]


@pytest.mark.parametrize("make", [scenes.overview, scenes.scene, movement_and_ray.movements, sonar.ping])
def test_pictures_show_something_and_have_their_values(sim, tmp_path, make):
    sim.reset()
    figure = make(sim, tmp_path / "figure.png")
    assert picture(tmp_path / "figure.png").std() > 10
    assert figure.values or figure.rows
    assert all(len(row) == len(figure.columns) for row in figure.rows)
    json.dumps(paper.plain(figure.rows), allow_nan=False)
    if make is scenes.overview:
        parts = {row[0]: row[1:] for row in figure.rows}
        assert parts.keys() >= {"mountains", "station and its cage", "vehicle", "pipeline", "gate 1", "gate 4"}
        assert all(in_view for *_, in_view in parts.values())
        assert all(parts[f"rocks {number}"][2] == pytest.approx(-41.0, abs=0.6) for number in (1, 2, 3))  # on the bed


def test_one_ray_ends_at_its_first_hit_and_the_others_pass(sim, tmp_path):
    rows = movement_and_ray.ray(sim, tmp_path / "ray.png").rows
    found = [row for row in rows if row[1] == "gate_1"]
    assert [row[0] for row in found] == [6.6]  # the ring's own radius
    assert found[0][2] == pytest.approx(np.hypot(9.0, 6.6), abs=0.4)  # its bar is 0.38 m thick
    assert all(row[2] > 15 for row in rows if row not in found)
    assert picture(tmp_path / "ray.png").std() > 10


def test_the_depth_map_agrees_with_rays(sim, tmp_path):
    assert sonar.depth_image(sim, tmp_path / "depth.png").values["mean_m"] < 0.1


def test_the_lawn_mower_keeps_its_depth_and_maps_the_bed_and_the_walls_that_it_turned_at(tmp_path):
    figure = mown_map.mown_map(tmp_path / "map.png", tmp_path / "map.bt")
    assert figure.values["collisions"] == 0
    assert figure.values["lanes"] >= 6
    assert 4.8 < figure.values["least_depth_m"] < figure.values["greatest_depth_m"] < 5.8
    assert figure.values["bed_mapped_percent"] > 50
    assert (tmp_path / "map.bt").stat().st_size > 20_000
    x, y, _ = np.transpose(figure.rows)
    assert (x.min(), x.max()) == pytest.approx((-22.0, 29.0), abs=6.0)  # between the walls
    assert y.min() < -170


def test_mistakes_are_one_line(tmp_path):
    assert re.search("WHAT = 'poster': must be one of paper", error_line(uwsim("reproduce", "poster")))
