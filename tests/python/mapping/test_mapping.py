"""Maps and their files, verified with OctoMap's own tools."""

import re
import subprocess
import threading

import numpy as np
import pytest

from uwsim import Simulator
from uwsim.flight.survey import fly_survey
from uwsim.mapping import OccupancyMap, ranging

TILT_RAD = np.radians(35)


def floor_ranges_m(altitude_m=8.0):
    """Return the ranges of a model 2 sonar that is tilted down over a flat floor."""
    variant = ranging.MODELS[2]
    angles_rad = variant.angle_min_rad + variant.angle_increment_rad * np.arange(variant.beams)
    return (altitude_m / (np.cos(angles_rad) * np.sin(TILT_RAD))).astype(np.float32)


def world_from_sonar(x_m):
    pose = np.eye(4)
    pose[:3, :3] = [[np.cos(TILT_RAD), 0, np.sin(TILT_RAD)], [0, 1, 0], [-np.sin(TILT_RAD), 0, np.cos(TILT_RAD)]]
    pose[:3, 3] = [x_m, 0.1, -0.1]
    return pose


def insert_text(occupancy_map, text, pose):
    """Run the whole chain from a ping's text to the map: text, ranges, scan, cloud, world, map."""
    scan = ranging.to_laser_scan(ranging.decode_depth_string(text))
    points_world_m = ranging.transform_points(ranging.to_point_cloud(scan), pose)
    occupancy_map.insert_scan(points_world_m, pose[:3, 3], max_range_m=55.0)


def surveyed(pings=30, resolution_m=0.5):
    occupancy_map = OccupancyMap(resolution_m)
    for ping in range(pings):
        insert_text(occupancy_map, ranging.encode_depth_string(floor_ranges_m()), world_from_sonar(0.2 * ping))
    return occupancy_map


def rows(points):
    return {tuple(row) for row in np.asarray(points).tolist()}


def flown():
    return fly_survey(Simulator("pool", mission_time_s=30.0))[0]


@pytest.mark.parametrize("make_map", [surveyed, flown])
def test_octomap_tools_find_the_same_voxels(make_map, tmp_path):
    occupancy_map = make_map()
    for suffix in ("bt", "ot"):
        occupancy_map.write(tmp_path / f"map.{suffix}")

    def run(*command):
        return subprocess.run(command, cwd=tmp_path, check=True, capture_output=True, text=True, timeout=300).stdout

    run("bt2vrml", "map.bt")
    vrml = (tmp_path / "map.bt.wrl").read_text()
    leaves = re.findall(r"translation (\S+) (\S+) (\S+)\s+children \[ Shape \{ geometry Box \{ size (\S+)", vrml)
    voxels = set()
    for *centre, size in np.array(leaves, dtype=float):
        offsets = np.arange(0.25, size, 0.5) - size / 2
        voxels |= rows(np.stack(np.meshgrid(*[offsets] * 3), axis=-1).reshape(-1, 3) + centre)
    assert voxels == rows(occupancy_map.occupied_voxels())

    run("convert_octree", "map.ot", "converted.bt")
    assert (tmp_path / "converted.bt").read_bytes() == (tmp_path / "map.bt").read_bytes()
    run("convert_octree", "map.bt", "converted.ot")
    OccupancyMap.read(tmp_path / "map.bt").write(tmp_path / "read.ot")
    assert "KLD: 0\n" in run("compare_octrees", "read.ot", "converted.ot")


def test_one_corrupted_number_changes_the_map():
    text = ranging.encode_depth_string(floor_ranges_m())
    values = text.split("a")
    values[256] = "5.5"
    maps = [OccupancyMap(0.5), OccupancyMap(0.5)]
    for occupancy_map, wire in zip(maps, (text, "a".join(values)), strict=True):
        insert_text(occupancy_map, wire, world_from_sonar(0.0))
    hit_m = world_from_sonar(0.0) @ [5.5, 0, 0, 1]
    assert [int(m.state_at([hit_m[:3]])[0]) for m in maps] == [0, 1]
    assert maps[0].to_bytes("bt") != maps[1].to_bytes("bt")
    values[256] = "5.x"
    with pytest.raises(ValueError, match=re.escape("depth_string[256] = '5.x'")):
        insert_text(maps[0], "a".join(values), world_from_sonar(0.0))


def test_calls_from_another_thread_do_not_change_the_bytes():
    occupancy_map, done = OccupancyMap(0.5), threading.Event()

    def bystander():
        while not done.is_set():
            occupancy_map.to_bytes("ot")
            occupancy_map.statistics()
            occupancy_map.free_voxels()

    thread = threading.Thread(target=bystander)
    thread.start()
    try:
        for ping in range(30):
            insert_text(occupancy_map, ranging.encode_depth_string(floor_ranges_m()), world_from_sonar(0.2 * ping))
    finally:
        done.set()
        thread.join()
    undisturbed = surveyed(30)
    assert occupancy_map.to_bytes("bt") == undisturbed.to_bytes("bt")
    assert occupancy_map.to_bytes("ot") == undisturbed.to_bytes("ot")


def test_each_bad_file_is_one_clear_error(tmp_path, capfd):
    path = tmp_path / "map.bt"
    with pytest.raises(OSError, match=r"map\.bt': cannot be read: no such file"):
        OccupancyMap.read(path)
    data = surveyed(3).to_bytes("bt")
    for bad, rule in [(b"PNG", "not an OctoMap file"), (data[:-1], "cut short"), (data + b"\0", "follow the end")]:
        path.write_bytes(bad)
        with pytest.raises(ValueError, match=rule):
            OccupancyMap.read(path)
    with pytest.raises(ValueError, match=r"must end in \.bt or \.ot"):
        OccupancyMap().write(tmp_path / "map.png")
    with pytest.raises(OSError, match="cannot be written"):
        OccupancyMap().write(tmp_path / "none" / "map.bt")
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("points", "origin", "rule"),
    [
        ([[1e6, 0, 0]], [0, 0, 0], "must be within"),
        ([[1e300, 0, 0]], [0, 0, 0], "must fit a float32"),
        ([[1, 0, 0]], [np.nan, 0, 0], "must be finite"),
        ([[1, 0]], [0, 0, 0], r"expected \(n, 3\)"),
        ([[True, False, True]], [0, 0, 0], "must be real numbers"),
    ],
)
def test_scan_is_inserted_whole_or_not_at_all(points, origin, rule):
    occupancy_map = OccupancyMap()
    with pytest.raises(ValueError, match=rule):
        occupancy_map.insert_scan(points, origin)
    occupancy_map.insert_scan([[np.nan, 0, 0], [np.inf, 0, 0]], [0, 0, 0])
    assert occupancy_map.statistics().nodes == 0


@pytest.mark.parametrize("resolution_m", [0, -1, np.nan, 1e-6, 1e6])
def test_resolution_out_of_range_is_refused(resolution_m):
    with pytest.raises(ValueError, match=r"map\.resolution_m = .*: must be in \[0\.001, 1000\] m"):
        OccupancyMap(resolution_m)


def test_repr_gives_resolution_and_origin():
    shown = "OccupancyMap(resolution_m=0.5, origin_world_m=(1, 2, 3): 0 occupied and 0 free voxels)"
    assert repr(OccupancyMap(0.5, [1, 2, 3])) == shown
