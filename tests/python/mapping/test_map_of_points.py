"""`uwsim map build` from clouds and from OctoMap's scan graphs, whose maps have the bytes of OctoMap's own tools."""

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

from command_line import uwsim as command
from uwsim.mapping import OccupancyMap
from uwsim.mapping.files import read_cloud, write_cloud
from uwsim.mapping.files.scan_graph import read_scans

RNG = np.random.default_rng(3)
needs_octomap = pytest.mark.skipif(shutil.which("graph2tree") is None, reason="apt install octomap-tools")


def graph(folder: Path) -> Path:
    """Scans of random points from tilted poses, as OctoMap's log2graph writes them."""
    lines = []
    for _ in range(6):
        place, angles = RNG.uniform((-5, -5, -2), (5, 5, 2)), RNG.uniform((-0.3, -0.3, -3), (0.3, 0.3, 3))
        lines.append(f"NODE {' '.join(map(str, [*place, *angles]))}")
        lines += [" ".join(map(str, point)) for point in RNG.uniform((-9, -9, -3), (9, 9, 3), (800, 3))] + [""]
    (folder / "a.log").write_text("\n".join(lines))
    subprocess.run(["log2graph", "a.log", "a.graph"], cwd=folder, check=True, capture_output=True)
    return folder / "a.graph"


@needs_octomap
def test_a_scan_graph_becomes_the_map_of_octomap_s_own_tool(tmp_path: Path) -> None:
    source = graph(tmp_path)
    own = ["graph2tree", "-i", source, "-o", tmp_path / "own.bt", "-res", "0.2"]
    subprocess.run(own, check=True, capture_output=True)
    done = command("map", "build", tmp_path / "ours.bt", "--from", source, "--voxel", "0.2")
    assert done.returncode == 0 and "6 scans, 4,800 points" in done.stdout, done.stderr
    assert (tmp_path / "ours.bt").read_bytes() == (tmp_path / "own.bt").read_bytes()


@needs_octomap
def test_a_damaged_scan_graph_is_refused_in_one_line(tmp_path: Path) -> None:
    whole = graph(tmp_path).read_bytes()
    cut, odd = whole[:5000], whole[:12] + b"\xff" * 8 + whole[20:]
    for content, words in ((cut, "is cut short, 6 scans"), (odd, "not finite"), (b"\0", "number of its scans")):
        (tmp_path / "bad.graph").write_bytes(content)
        done = command("map", "build", tmp_path / "bad.bt", "--from", tmp_path / "bad.graph")
        assert done.returncode == 1 and words in done.stderr and len(done.stderr.splitlines()) == 1
        assert not (tmp_path / "bad.bt").exists()
    assert len(list(read_scans(tmp_path / "a.graph"))) == 6


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".las", ".laz", ".xyz"])
def test_a_cloud_is_seen_from_a_place_or_occupied_only(suffix: str, tmp_path: Path) -> None:
    points = RNG.uniform((-5, -5, -9), (5, 5, -8), (2000, 3)).round(3).astype(np.float32)
    write_cloud(tmp_path / f"a{suffix}", points)
    seen, occupied = tmp_path / "seen.bt", tmp_path / "occupied.bt"
    made = command("map", "build", seen, "--from", tmp_path / f"a{suffix}", "--sensor-at", 0, 0, -1, "--voxel", 0.5)
    assert made.returncode == 0, made.stderr
    wanted = OccupancyMap(resolution_m=0.5)
    wanted.insert_scan(points, np.array([0.0, 0.0, -1.0]), np.inf)
    wanted.write(tmp_path / "wanted.bt")
    assert seen.read_bytes() == (tmp_path / "wanted.bt").read_bytes()
    made = command("map", "build", occupied, "--from", tmp_path / f"a{suffix}", "--occupied-only", "--voxel", 0.5)
    assert made.returncode == 0, made.stderr
    found = OccupancyMap.read(occupied)
    assert found.count() == (len(np.unique(np.floor(points / 0.5), axis=0)), 0)


@pytest.mark.parametrize("suffix", [".ply", ".pcd", ".las", ".xyz"])
def test_a_georeferenced_cloud_becomes_a_map_about_its_own_middle_that_keeps_its_place(
    suffix: str, tmp_path: Path
) -> None:
    """In UTM, to a voxel, though a float32 would move points by half a metre."""
    near = RNG.uniform((-9, -9, -13), (9, 9, -12), (2000, 3)).round(3)
    at = np.array([500_000.0, 5_700_000.0, 0.0])
    write_cloud(tmp_path / f"a{suffix}", near + at)
    made = command("map", "build", "a.bt", "--from", f"a{suffix}", "--occupied-only", "--voxel", 0.5, cwd=tmp_path)
    assert made.returncode == 0 and "; zero at 500000 5700000 0, which the file states" in made.stdout, made.stderr
    found = OccupancyMap.read(tmp_path / "a.bt")
    wanted = np.unique(np.floor(near / 0.5), axis=0)
    np.testing.assert_array_equal(np.unique(np.floor((found.occupied_voxels() - at) / 0.5), axis=0), wanted)
    np.testing.assert_array_equal(found.origin_world_m, at)
    first, line, rest = (tmp_path / "a.bt").read_bytes().split(b"\n", 2)
    assert line == b"# origin_world_m 500000.0 5700000.0 0.0" and found.to_bytes("bt") == b"\n".join(
        (first, line, rest)
    )
    for step in (("convert", "a.bt", "b.ot"), ("merge", "a.bt", "b.ot", "--out", "c.ot"), ("convert", "c.ot", "d.las")):
        assert command("map", *step, cwd=tmp_path).returncode == 0
    cloud = read_cloud(tmp_path / "d.las")
    np.testing.assert_array_equal(np.unique(np.floor((cloud - at) / 0.5), axis=0), wanted)
    options = "--occupied-only", "--voxel", 0.5, "--origin", 500_010, 5_700_000
    assert command("map", "build", "e.bt", "--from", f"a{suffix}", *options, cwd=tmp_path).returncode == 0
    np.testing.assert_array_equal(OccupancyMap.read(tmp_path / "e.bt").origin_world_m, at + np.array([10, 0, 0]))
    (tmp_path / "f.bt").write_bytes(b"\n".join((first, b"# origin_world_m 1 2 inf", rest)))
    with pytest.raises(ValueError, match="origin_world_m '1 2 inf': must be three numbers within 1e"):
        OccupancyMap.read(tmp_path / "f.bt")


@needs_octomap
def test_octomap_s_own_tools_skip_the_origin(tmp_path: Path) -> None:
    write_cloud(tmp_path / "a.xyz", RNG.uniform(-2, 2, (500, 3)) + np.array([5e5, 5.7e6, 0.0]))
    made = command("map", "build", "a.bt", "--from", "a.xyz", "--occupied-only", "--voxel", 0.5, cwd=tmp_path)
    assert made.returncode == 0, made.stderr
    subprocess.run(["convert_octree", "a.bt", "own.ot"], cwd=tmp_path, check=True, capture_output=True)
    occupied = OccupancyMap.read(tmp_path / "a.bt", (0.0, 0.0, 0.0)).occupied_voxels()
    np.testing.assert_array_equal(OccupancyMap.read(tmp_path / "own.ot").occupied_voxels(), occupied)


def test_a_pcd_that_states_its_viewpoint_is_seen_from_there(tmp_path: Path) -> None:
    points = RNG.uniform((-5, -5, -9), (5, 5, -8), (500, 3)).astype(np.float32)
    write_cloud(tmp_path / "a.pcd", points)
    stated = (tmp_path / "a.pcd").read_bytes().replace(b"VIEWPOINT 0 0 0 1 0 0 0", b"VIEWPOINT 1 2 -1.5 0.8 0 0 0.6")
    (tmp_path / "a.pcd").write_bytes(stated)
    made = command("map", "build", "a.bt", "--from", "a.pcd", "--voxel", 0.5, cwd=tmp_path)
    assert made.returncode == 0 and "a.pcd: seen from 1 2 -1.5, its VIEWPOINT" in made.stdout, made.stderr
    wanted = OccupancyMap(resolution_m=0.5)
    wanted.insert_scan(points, np.array([1.0, 2.0, -1.5]), np.inf)
    assert (tmp_path / "a.bt").read_bytes() == wanted.to_bytes("bt")
    (tmp_path / "a.pcd").write_bytes(stated.replace(b"-1.5 0.8", b"nan 0.8"))
    made = command("map", "build", "b.bt", "--from", "a.pcd", cwd=tmp_path)
    assert made.returncode == 1 and "VIEWPOINT 1 2 nan 0.8 0 0 0.6: must be seven numbers" in made.stderr


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ((), "does not state where it was seen from: give --sensor-at X Y Z or --occupied-only"),
        (("--sensor-at", 0, 0, 0, "--occupied-only"), "must not be given beside --occupied-only"),
        (("--from", "b.gsf", "--sensor-at", 0, 0, 0), "surveys, clouds and graphs cannot be mixed"),
        (("--occupied-only", "--from", "b.gsf"), "surveys, clouds and graphs cannot be mixed"),
    ],
)
def test_what_a_cloud_needs_is_asked_for(options: tuple[object, ...], words: str, tmp_path: Path) -> None:
    write_cloud(tmp_path / "a.ply", np.zeros((3, 3)))
    (tmp_path / "b.gsf").write_bytes(b"GSF-v03.09")
    done = command("map", "build", "a.bt", "--from", "a.ply", *options, cwd=tmp_path)
    assert done.returncode != 0 and words in done.stderr and not (tmp_path / "a.bt").exists()
