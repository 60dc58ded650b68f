"""`uwsim scenario from` a COLMAP model: our own pictures of a bed become that bed, in water of the same attenuation."""

import re
import struct
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import uwsim
from command_line import uwsim as command
from uwsim.evidence.photos.colmap import read_model
from uwsim.evidence.photos.placement import place
from uwsim.evidence.photos.water import type_attenuation
from uwsim.evidence.photos.world import attenuation_text
from uwsim.evidence.scenario_source import source_of
from uwsim.evidence.vision.colmap import build
from uwsim.instruments.cameras.frame import Frame
from uwsim.scenario import build_world, load

PICTURES, PER_PICTURE, SEEN_M = 14, 160, 9.0
UNITS_PER_M, TURN = 2.7, Rotation.from_euler("ZYX", [70.0, 25.0, -140.0], degrees=True)
"""The model's own axes: COLMAP's have neither scale nor direction."""
COLOURS = [[0.7, 0.6, 0.5], [0.1, 0.1, 0.12], [0.5, 0.2, 0.1], [0.2, 0.4, 0.5], [0.8, 0.8, 0.8], [0.05, 0.15, 0.05]]
SCENE = {
    "name": "plates",
    "optics": {"jerlov": "II"},
    "terrain": {
        "source": "noise",
        "seed": 4,
        "size_m": [40, 40],
        "spacing_m": 0.25,
        "bed_depth_m": 8,
        "hill_height_m": 1.0,
        "hill_wavelength_m": 15,
    },
    "obstacles": [
        {
            "kind": "box",
            "name": f"plate_{k}",
            "position_m": [2.0 * (k % 5) - 4.0, 2.0 * (k // 5) - 4.0, 0.0],
            "size_m": [0.9, 0.9, 0.03],
            "on_bed": True,
            "material": {"kind": "plain", "colour": COLOURS[k % len(COLOURS)]},
        }
        for k in range(25)
    ],
    "vehicles": [{"name": "rov", "model": "bluerov2_heavy_outfit", "start": {"position_m": [0, 0, -3]}}],
}


class Dive(NamedTuple):
    """Pictures of a scene, their cameras in the world, and where each shows points of its surfaces."""

    sim: uwsim.Simulator
    folder: Path
    size: tuple[int, int]
    k: np.ndarray
    poses: np.ndarray
    points: np.ndarray
    seen: list[dict[int, np.ndarray]]


@pytest.fixture(scope="module")
def dive(tmp_path_factory: pytest.TempPathFactory) -> Dive:
    folder = tmp_path_factory.mktemp("dive")
    sim, random = uwsim.Simulator(SCENE, seed=3), np.random.default_rng(1)
    sim.rov.release()
    frames = []
    for k in range(PICTURES):
        turn, reach, up = 2.4 * k, 1.0 + 4.0 * random.random(), 1.2 + 3.0 * random.random()
        x, y = reach * np.cos(turn), reach * np.sin(turn)
        z = float(sim.world.height_at([[x, y]])[0]) + up
        heading = turn + np.pi + random.uniform(-0.5, 0.5)
        sim.rov.place((x, y, z), Rotation.from_euler("ZYX", [heading, 0.8, 0.0]).as_quat())
        frames.append(sim.rov.cameras["front"].capture())
        frames[-1].save(folder / f"{k:03d}.png")
        sim.advance(0.5)
    poses, intrinsics = np.array([frame.world_from_optical for frame in frames]), frames[0].info.k
    height, width = frames[0].depth_m.shape
    points = []
    for frame, pose in zip(frames, poses, strict=True):
        row, column = random.integers(0, height, PER_PICTURE), random.integers(0, width, PER_PICTURE)
        depth = frame.depth_m[row, column]
        row, column, depth = (each[depth < SEEN_M] for each in (row, column, depth))
        own = np.column_stack([column, row, np.ones(len(row))]) @ np.linalg.inv(intrinsics).T * depth[:, None]
        points.append(own @ pose[:3, :3].T + pose[:3, 3])
    surface = np.concatenate(points)
    seen = [_seen(frame, intrinsics, pose, surface) for frame, pose in zip(frames, poses, strict=True)]
    return Dive(sim, folder, (width, height), intrinsics, poses, surface, seen)


def _seen(frame: Frame, k: np.ndarray, pose: np.ndarray, points: np.ndarray) -> dict[int, np.ndarray]:
    """The pixels (centres have whole coordinates) at which a frame shows points, by the points' numbers."""
    own = (points - pose[:3, 3]) @ pose[:3, :3]
    at = (own / np.where(own[:, 2:] > 0.1, own[:, 2:], np.nan)) @ k.T
    height, width = frame.depth_m.shape
    found = {}
    for n in np.flatnonzero((at[:, 0] > 1) & (at[:, 0] < width - 2) & (at[:, 1] > 1) & (at[:, 1] < height - 2)):
        shown = frame.depth_m[round(at[n, 1]), round(at[n, 0])]
        if abs(shown - own[n, 2]) < 0.02 * own[n, 2] and own[n, 2] < SEEN_M:
            found[int(n)] = at[n, :2]
    return found


def _in_model(dive: Dive) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Quaternions w x y z and translations, camera from world, and points, in the model's axes and unit."""
    turn = TURN.as_matrix()
    from_world = np.transpose(turn @ dive.poses[:, :3, :3], (0, 2, 1))
    centres = UNITS_PER_M * dive.poses[:, :3, 3] @ turn.T
    q = Rotation.from_matrix(from_world).as_quat()[:, [3, 0, 1, 2]]
    return q, -np.einsum("kij,kj->ki", from_world, centres), UNITS_PER_M * dive.points @ turn.T


def write_text(dive: Dive, folder: Path) -> None:
    q, t, points = _in_model(dive)
    k, (width, height) = dive.k, dive.size
    lens = f"{k[0, 0]} {k[1, 1]} {k[0, 2] + 0.5} {k[1, 2] + 0.5}"
    (folder / "cameras.txt").write_text(f"# CAMERA_ID, MODEL, ...\n7 PINHOLE {width} {height} {lens}\n")
    lines = ["# IMAGE_ID, ..."]
    for n, seen in enumerate(dive.seen):
        lines.append(f"{n + 1} {' '.join(map(repr, map(float, [*q[n], *t[n]])))} 7 {n:03d}.png")
        lines.append(" ".join(f"{float(u) + 0.5!r} {float(v) + 0.5!r} {point + 10}" for point, (u, v) in seen.items()))
    (folder / "images.txt").write_text("\n".join(lines) + "\n")
    rows = [f"{n + 10} {' '.join(map(repr, map(float, point)))} 9 9 9 0.5 1 0\n" for n, point in enumerate(points)]
    (folder / "points3D.txt").write_text("".join(rows))


def write_binary(dive: Dive, folder: Path) -> None:
    q, t, points = _in_model(dive)
    k, (width, height) = dive.k, dive.size
    lens = (k[0, 0], k[1, 1], k[0, 2] + 0.5, k[1, 2] + 0.5)
    (folder / "cameras.bin").write_bytes(struct.pack("<QIiQQ4d", 1, 7, 1, width, height, *lens))
    images = struct.pack("<Q", len(dive.seen))
    for n, seen in enumerate(dive.seen):
        images += (
            struct.pack("<I7dI", n + 1, *q[n], *t[n], 7) + f"{n:03d}.png\0".encode() + struct.pack("<Q", len(seen))
        )
        images += b"".join(struct.pack("<ddq", u + 0.5, v + 0.5, point + 10) for point, (u, v) in seen.items())
    (folder / "images.bin").write_bytes(images)
    rows = [struct.pack("<Q3d3BdQII", n + 10, *point, 9, 9, 9, 0.5, 1, 1, 0) for n, point in enumerate(points)]
    (folder / "points3D.bin").write_bytes(struct.pack("<Q", len(points)) + b"".join(rows))


def positions(dive: Dive, file: Path) -> Path:
    rows = [f"{n:03d}.png,{x:.4f},{y:.4f},{-z:.4f}\n" for n, (x, y, z) in enumerate(dive.poses[:, :3, 3])]
    file.write_text("image,easting,northing,depth_m\n" + "".join(rows))
    return file


def test_a_dive_becomes_the_world_that_it_was_in(dive: Dive, tmp_path: Path) -> None:
    """Bed, place and attenuation are the scene's; the command reports what it assumed; its world is flown."""
    write_binary(dive, dive.folder)
    out = tmp_path / "made"
    done = command("scenario", "from", dive.folder, "--out", out, "--positions", positions(dive, tmp_path / "at.csv"))
    assert done.returncode == 0, done.stderr
    made = load(out / "made.yaml")
    c = [float(each) for each in re.findall(r"(?:red|green|blue) ([\d.]+)", done.stdout)]
    origin = done.stdout.split("the world's origin is (")[1].split(")")[0].split(",")
    at = np.array([[x, y] for x in np.arange(-3.0, 3.1, 0.5) for y in np.arange(-3.0, 3.1, 0.5)])
    off = build_world(made).height_at(at - [float(each) for each in origin]) - dive.sim.world.height_at(at)
    assert np.median(np.abs(off)) < 0.02
    assert c == pytest.approx(type_attenuation("II"), rel=0.15)
    assert made.optics.jerlov == "II"
    assert uwsim.Simulator(made).rov.sonar.ping().ranges_m.min() > 0.5
    for words in ("read: ", "left out: the lens", "assumed: the bed scatters sound as sand", "+-"):
        assert words in done.stdout


def test_text_and_binary_are_the_same_model(dive: Dive, tmp_path: Path) -> None:
    write_text(dive, tmp_path)
    write_binary(dive, dive.folder)
    text, binary = read_model(tmp_path), read_model(dive.folder)
    assert text.pictures == binary.pictures
    for key in ("sizes", "centres", "turns", "points", "errors", "seen_in", "seen_point", "seen_at"):
        np.testing.assert_allclose(getattr(text, key), getattr(binary, key), rtol=1e-12, atol=1e-12)
    assert binary.centres == pytest.approx(UNITS_PER_M * TURN.apply(dive.poses[:, :3, 3]))


def test_up_is_found_from_cameras_that_do_not_roll(dive: Dive, tmp_path: Path) -> None:
    write_text(dive, tmp_path)
    placement = place(read_model(tmp_path), scale=1.0 / UNITS_PER_M, positions=None)
    assert placement.turn @ TURN.apply([0.0, 0.0, 1.0]) == pytest.approx([0.0, 0.0, 1.0], abs=0.01)
    assert placement.scale == pytest.approx(1.0 / UNITS_PER_M)
    assert any("assumed: up" in note for note in placement.notes)


def _cut(name: str, size: int) -> Callable[[Path], None]:
    return lambda folder: (folder / name).write_bytes((folder / name).read_bytes()[:size])


def _count(name: str) -> Callable[[Path], None]:
    return lambda folder: (folder / name).write_bytes(b"\xff" * 7 + b"\x7f" + (folder / name).read_bytes()[8:])


HOSTILE = {
    **{
        f"cut {name} {size}": (_cut(f"{name}.bin", size), f"{name}.bin")
        for name in ("cameras", "images", "points3D")
        for size in (0, 5, 60, -3)
    },
    **{f"count {name}": (_count(f"{name}.bin"), f"{name}.bin") for name in ("cameras", "images", "points3D")},
    "longer": (lambda folder: (folder / "images.bin").open("ab").write(b"\0"), "images.bin"),
}


@pytest.mark.parametrize("name", HOSTILE)
def test_a_damaged_model_is_an_error_that_names_the_file(name: str, dive: Dive, tmp_path: Path) -> None:
    harm, file = HOSTILE[name]
    write_binary(dive, tmp_path)
    harm(tmp_path)
    with pytest.raises(ValueError, match=file.replace(".", r"\.")):
        source_of(tmp_path).make(tmp_path, tmp_path / "made", {})
    assert not (tmp_path / "made").exists()


def test_what_a_model_lacks_is_assumed_or_refused(dive: Dive, tmp_path: Path) -> None:
    """Without pictures, scale and positions, the bed is made, and each assumption is a note."""
    write_text(dive, tmp_path)
    made = source_of(tmp_path).make(tmp_path, tmp_path / "made", {"scale": 1.0 / UNITS_PER_M, "depth": 25.0})
    assert build_world(load(made.path)).height_at([[0.0, 0.0]])[0] == pytest.approx(-25.0, abs=1.0)
    notes = "\n".join(made.notes)
    assert all(words in notes for words in ("left out: colours", "assumed: north", "assumed: up"))
    short = tmp_path / "short.csv"
    short.write_text("name,x_m,y_m,z_m\n000.png,0,0,-3\n001.png,1,0,-3\n")
    with pytest.raises(ValueError, match="must have 3 or more"):
        source_of(tmp_path).make(tmp_path, tmp_path / "other", {"positions": short})


def test_a_dense_mesh_beside_the_model_is_the_bed(dive: Dive, tmp_path: Path) -> None:
    """A file of COLMAP's dense reconstruction is gridded in place of the sparse points, which see too little."""
    from trimesh import Trimesh

    write_text(dive, tmp_path)
    east, north = (each.ravel() for each in np.meshgrid(np.arange(-5.0, 5.1, 0.2), np.arange(-5.0, 5.1, 0.2)))
    surface = np.column_stack([east, north, -7.0 + 0.1 * east])
    corners = np.arange(3 * (len(surface) // 3)).reshape(-1, 3)
    Trimesh(UNITS_PER_M * TURN.apply(surface), corners, process=False).export(tmp_path / "meshed-poisson.ply")
    given = {"positions": positions(dive, tmp_path / "at.csv"), "cell": 0.2}
    made = source_of(tmp_path).make(tmp_path, tmp_path / "made", given)
    assert any("meshed-poisson.ply" in note for note in made.notes)
    found = build_world(load(made.path)).height_at([[-2.0, 0.0], [2.0, 0.0]])
    assert found[1] - found[0] == pytest.approx(0.4, abs=0.01)


def test_a_band_that_is_badly_determined_is_given_by_its_interval() -> None:
    assert attenuation_text("red", 0.276, 0.04) == "red 0.276 +- 0.040"
    assert attenuation_text("blue", 0.112, 0.06) == "blue badly determined, 0.052 to 0.172"
    assert attenuation_text("blue", 0.03, 0.05) == "blue badly determined, 0.000 to 0.080"
    assert attenuation_text("blue", 0.03, np.inf) == "blue not determined"


def test_colmap_itself_closes_the_loop(tmp_path: Path) -> None:
    """COLMAP finds cameras and points in our own pictures of a reef; bed and water follow from its files."""
    pytest.importorskip("pycolmap", reason="pycolmap, of 100 MB, is not installed")
    sim = uwsim.Simulator("reef")
    sim.rov.release()
    bed_m, frames = float(sim.world.height_at([[0.0, 0.0]])[0]), {}
    for k in range(24):
        turn = 2.0 * np.pi * k / 48
        place_m = (4.0 * np.cos(turn), 4.0 * np.sin(turn), bed_m + 2.5)
        sim.rov.place(place_m, Rotation.from_euler("ZYX", [turn + np.pi, np.arctan2(2.5, 4.0), 0.0]).as_quat())
        frames[f"{k:03d}.png"] = sim.rov.cameras["front"].capture()
        sim.advance(0.5)
    build(tmp_path, frames)
    rows = [(name, *frame.world_from_optical[:3, 3]) for name, frame in frames.items()]
    at = tmp_path / "at.csv"
    at.write_text("name,x_m,y_m,z_m\n" + "".join(f"{name},{x},{y},{z}\n" for name, x, y, z in rows))
    made = source_of(tmp_path).make(tmp_path, tmp_path / "made", {"positions": at})
    model = read_model(tmp_path / "sparse" / "0").reliable()
    placement = place(model, scale=None, positions=at)
    off = []
    for seen_in, point, (u, v) in zip(model.seen_in, model.seen_point, model.seen_at, strict=True):
        frame = frames[model.pictures[seen_in]]
        way = placement.placed(model.points[[point]])[0] - frame.world_from_optical[:3, 3]
        ahead = float(way @ frame.world_from_optical[:3, 2])
        off.append(abs((frame.depth_m[int(v), int(u)] - ahead) / ahead * way[2]))
    assert len(model.pictures) >= 20
    assert np.median(off) < 0.03
    assert load(made.path).optics.jerlov == "IB", "\n".join(made.notes)
