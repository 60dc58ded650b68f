"""The files and pages that the operator's station serves over HTTP, and who may load them."""

import io
import json

import numpy as np
import pytest
import shapely
import trimesh
from PIL import Image

from station_pages import get, page, serving
from uwsim.bridges import RosbridgeServer
from uwsim.bridges.doors.admission import has_token
from uwsim.mapping import OccupancyMap
from uwsim.operator.station import Site, Station
from uwsim.operator.station.start.preview import AREA, OBSTACLE, STATION
from waiting import until

OUTSIDE = ("/../station.py", "/%2e%2e/station.py", "/..%2f..%2fsimulator.py", "//etc/passwd", "/no", "/%00", "/style")


@pytest.fixture(scope="module")
def pool():
    """A station with a running pool, for tests that do not stop it."""
    with serving() as (station, server):
        station.start({"scenario": "pool"})
        yield station, server


def test_the_start_screen_has_a_picture_of_each_scenario_from_above():
    with serving() as (_, server):
        status, body, headers = get(server, "/preview/pool.png")
        assert (status, headers["Content-Type"]) == (200, "image/png")
        picture = np.asarray(Image.open(io.BytesIO(body)).convert("RGB"))
        height, width, _ = picture.shape
        assert width == height  # 20 m

        def colour_at(x_m, y_m):
            return tuple(picture[round(height * (10.0 - y_m) / 20.0), round(width * (10.0 + x_m) / 20.0)])

        assert (colour_at(3.0, 0.0), colour_at(-6.0, 0.0), colour_at(4.0, 2.0)) == (OBSTACLE, STATION, AREA)
        assert colour_at(0.0, 2.0) == colour_at(0.0, -2.0)  # both on the flat bed
        assert get(server, "/preview/../pool.png")[0] == get(server, "/preview/nowhere.png")[0] == 404
        assert get(server, "/a" * 4000)[0] == get(server, "/" + "a" * 4000)[0] == 404  # too long for a file name
    with serving(is_fixed=True) as (_, server):
        assert get(server, "/preview/pool.png")[0] == 404


def test_the_map_goes_home_in_every_format(tmp_path):
    with serving(tmp_path) as (station, server), page(server) as ada:
        ada.call("start", scenario="pool", speed=2)
        until(lambda: station.present().live.tick >= 200, "the map of a docked vehicle, which no longer changes")
        ada.subscribe("/map_changes", throttle_rate=100)
        first = ada.message("/map_changes")
        assert first["snapshot"] and len(first["cells"]) > 0
        ada.call("take_control")
        ada.call("control", action="pause")
        status, body, headers = get(server, "/map/rov.bt")
        assert (status, headers["Content-Disposition"]) == (200, 'attachment; filename="pool-rov.bt"')
        (tmp_path / "map.bt").write_bytes(body)
        assert len(OccupancyMap.read(tmp_path / "map.bt").occupied_voxels()) > 20
        for suffix, start in (("ply", b"ply"), ("pcd", b"# .PCD"), ("tif", b"II*\0")):
            status, body, _ = get(server, f"/map/rov.{suffix}")
            assert status == 200 and body.startswith(start)
        assert get(server, "/map/boat.bt")[0] == get(server, "/map/rov.exe")[0] == 404
        assert "saved" in ada.call("control", action="save", name="dive-1")["message"]
        saved = {path.name for path in (tmp_path / "dive-1").iterdir()}
        assert saved >= {"rov.bt", "rov.ot", "state", "commands.json", "scenario.json"}
        assert "already exists" in ada.call("control", action="save", name="dive-1")["message"]
        assert "must have" in ada.call("control", action="save", name="../dive")["message"]
        status, body, _ = get(server, "/snapshot/front.png")
        picture = Image.open(io.BytesIO(body))
        assert status == 200 and picture.size == (640, 360)
        assert json.loads(picture.text["uwsim"])["panel"]["released"] is False
        assert get(server, "/snapshot/none.png")[0] == 404


def test_the_scene_is_the_world(pool):
    station, server = pool
    world = station.present().live.simulator.world
    scene = json.loads(get(server, "/scene/scene.json")[1])
    grid = scene["terrain"]
    heights = np.frombuffer(get(server, grid["url"])[1], "<f4").reshape(grid["rows"], grid["columns"])
    row, column = grid["rows"] // 3, grid["columns"] // 4
    x, y = grid["west_m"] + column * grid["spacing_m"][0], grid["south_m"] + row * grid["spacing_m"][1]
    assert heights[row, column] == pytest.approx(float(np.ravel(world.height_at([[x, y]]))[0]), abs=1e-4)
    meshes = [trimesh.load(io.BytesIO(get(server, part["url"])[1]), file_type="glb") for part in scene["meshes"]]
    assert len(meshes) == len(scene["meshes"]) > 0 and all(len(mesh.geometry) for mesh in meshes)
    hull = trimesh.load(io.BytesIO(get(server, scene["vehicles"][0]["url"])[1]), file_type="glb")
    assert 0.5 < np.ptp(hull.bounds, axis=0).max() < 3.0
    assert get(server, "/scene/mesh/999.glb")[0] == 404


def test_the_chart_of_a_pool_with_walls_is_the_pool():
    with serving() as (station, server):
        station.start({"scenario": "training_pool"})
        scene = json.loads(get(server, "/scene/scene.json")[1])
        grid = scene["chart"]
        heights = np.frombuffer(get(server, grid["url"])[1], "<f4").reshape(grid["rows"], grid["columns"])
        west, south, step = grid["west_m"], grid["south_m"], grid["spacing_m"][0]

        def height_m(x, y):
            return heights[round((y - south) / step), round((x - west) / step)]

        water = [height_m(x, y) for x in (-12, 0, 12) for y in (-9.5, 0, 9.5)]
        assert water == pytest.approx([-5.0] * 9, abs=0.3), "25 x 20 m, 5 m deep"
        assert all(height_m(x, y) > 0.0 for x, y in ((-14, 0), (14, 0), (0, -12), (0, 12))), "its deck"
        assert set(grid["meshes"]) == {"basin", "fittings"}


def test_the_chart_of_natural_water_is_its_bed(pool):
    assert json.loads(get(pool[1], "/scene/scene.json")[1])["chart"] is None
    assert get(pool[1], "/scene/chart.f32")[0] == 404


@pytest.mark.parametrize("scenario", ["lake", "harbour", "wreck", "valley"])
def test_nothing_stands_between_the_first_view_s_eye_and_the_vehicle(scenario):
    with serving() as (station, server):
        station.start({"scenario": scenario})
        sim = station.present().live.simulator
        away_m = np.array(json.loads(get(server, "/scene/scene.json")[1])["vehicles"][0]["look_m"])
        far_m = np.linalg.norm(away_m)
        eye_m = sim.rov.pose.position_world_m + away_m
        seen_m = sim.scene.cast(eye_m[None], -away_m[None] / far_m, 100.0).ranges_m[0]
        assert seen_m > far_m - 6.5, "nearer are only its dock and the vehicle's own start"
        assert far_m > 10.0 and away_m[2] > 5.0


def test_outlines_on_the_chart_are_those_of_the_obstacles():
    with serving() as (station, server):
        station.start({"scenario": "lake"})
        bent = {
            each.name: each for each in station.present().live.simulator.scenario.obstacles if each.kind == "pipeline"
        }
        parts = json.loads(get(server, "/scene/scene.json")[1])["meshes"]
        for part in parts:
            mesh = trimesh.load(io.BytesIO(get(server, part["url"])[1]), file_type="glb", force="mesh")
            drawn = shapely.Polygon(part["outline_m"])
            seen = shapely.points(mesh.vertices[:, :2])
            assert shapely.distance(drawn, seen).max() < 0.3, part["name"]  # pipes have round ends
            if part["name"] in bent:
                pipe = bent[part["name"]]
                length_m = shapely.LineString(pipe.points_m).length
                assert drawn.area == pytest.approx(2.0 * pipe.radius_m * length_m, rel=0.05), "not its convex hull"
        assert bent


def test_only_this_machine_s_pages_are_served_and_nothing_foreign_is_loaded(pool):
    _, server = pool
    status, body, headers = get(server, "/")
    assert status == 200 and b"<script" in body and b"http" not in body.replace(b"http-equiv", b"")
    policy = headers["Content-Security-Policy"]
    assert "default-src 'none'" in policy and "script-src 'self';" in policy and "unsafe" not in policy
    assert f"connect-src 'self' blob: ws://127.0.0.1:{server.port} wss://127.0.0.1:{server.port};" in policy
    assert get(server, "/", If_None_Match=headers["ETag"])[0] == 304
    assert (
        get(server, "/", Host="evil.example")[0] == get(server, "/map/rov.bt", Origin="http://evil.example")[0] == 403
    )
    mine = "http://localhost:5173"  # a user's own page
    assert get(server, "/scene/scene.json", Origin=mine)[2]["Access-Control-Allow-Origin"] == mine
    assert get(server, "/scene/scene.json")[2]["Access-Control-Allow-Origin"] is None
    assert get(server, "/snapshot/front.png", Sec_Fetch_Site="cross-site")[0] == 403  # an <img> on another site's page
    for path in OUTSIDE:
        assert get(server, path)[0] == 404, path


def test_a_token_guards_everything_but_the_page_s_own_files():
    station, token = Station(), "secret-token"
    site = Site(station, lambda request: has_token(request, token))
    with RosbridgeServer(None, guests=[station], site=site, token=token) as server, station.serving(server.show):
        station.start({"scenario": "pool"})
        for address in ("/", "/index.html", "/?token=wrong-token&rosbridge=%22%3E"):
            status, body, headers = get(server, address)
            assert status == 401 and b"asks for a token" in body and b'"">' not in body
            assert "form-action 'self'" in headers["Content-Security-Policy"]
        assert get(server, "/app.js")[0] == get(server, "/?token=secret-token")[0] == 200
        assert get(server, "/scene/scene.json")[0] == 401
        assert get(server, "/scene/scene.json?token=secret-token")[0] == 200
