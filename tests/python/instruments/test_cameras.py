"""Cameras and lamps as used from scripts: frames, lamps, light, files, errors."""

from __future__ import annotations

import io
import re
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.spatial.transform import Rotation

from test_imaging_mount import POOL
from uwsim import Simulator, _core
from uwsim.instruments.cameras import EFFECTS
from uwsim.scenario.build.camera import core_optics

BED_M = 5.0
"""Depth of the pool."""


@pytest.fixture
def pool() -> Simulator:
    sim = Simulator("pool", threads=2)
    sim.rov.place((0.0, 0.0, -3.0))
    return sim


def test_a_capture_gives_all_arrays_and_does_not_advance_time(pool: Simulator) -> None:
    before, camera = pool.time_ns, pool.rov.cameras["front"]
    frame, info = camera.capture(), camera.info
    assert pool.time_ns == before == frame.time_ns
    shapes = [frame.rgb, frame.depth_m, frame.normals_world, frame.labels, frame.classes]
    assert [a.shape for a in shapes] == [(360, 640, 3), (360, 640), (360, 640, 3), (360, 640), (360, 640)]
    assert [str(a.dtype) for a in shapes] == ["uint8", "float32", "float32", "uint16", "uint8"]
    assert not any(a.flags.writeable for a in shapes)
    hit = np.isfinite(frame.depth_m)
    np.testing.assert_allclose(np.linalg.norm(frame.normals_world[hit], axis=1), 1, atol=1e-5)
    assert (frame.labels[~hit] == 0).all()
    assert {"terrain", "box"} <= {frame.label_names[label] for label in np.unique(frame.labels[hit])}
    assert {frame.class_names[k] for k in np.unique(frame.classes[hit])} == {"terrain", "structure"}
    assert (info.width, info.height, info.distortion_model) == (640, 360, "plumb_bob")
    assert [each.shape for each in (info.k, info.r, info.p, info.d)] == [(3, 3), (3, 3), (3, 4), (5,)]
    np.testing.assert_allclose(np.degrees(2 * np.arctan(320 / info.k[0, 0])), 84)


def test_depth_and_intrinsics_recover_the_box_in_the_world(pool: Simulator) -> None:
    pool.rov.place((-1.0, 0.0, -4.0))
    frame = pool.rov.cameras["front"].capture(["shadows"])  # without distortion or wobble
    v, u = np.nonzero(frame.labels == frame.label_names.index("box"))
    k, depth = frame.info.k, frame.depth_m[v, u].astype(np.float64)
    optical = np.column_stack([(u - k[0, 2]) / k[0, 0] * depth, (v - k[1, 2]) / k[1, 1] * depth, depth])
    points = optical @ frame.world_from_optical[:3, :3].T + frame.world_from_optical[:3, 3]
    points = points[frame.normals_world[v, u, 0] < -0.9]  # the near face
    assert points.min(axis=0) == pytest.approx([2.5, -0.5, -5.0], abs=0.02)
    assert points.max(axis=0) == pytest.approx([2.5, 0.5, -4.0], abs=0.02)


def test_a_frame_depends_on_time_and_seed_but_not_on_threads() -> None:
    def lit(steps: int = 3, seed: int = 0, threads: int = 1) -> tuple[bytes, bytes]:
        sim = Simulator("pool", seed=seed)
        sim.rov.place((0.0, 0.0, -3.0))
        sim.rov.lamps["front"].on = True
        sim.step(steps)
        frame = sim.rov.cameras["front"].resized(320).capture(threads=threads)
        return frame.rgb.tobytes(), frame.depth_m.tobytes()

    first = lit()
    assert all(lit(threads=threads) == first for threads in (2, 7))
    assert lit(seed=5)[0] != first[0] != lit(steps=4)[0]


def test_captures_on_several_python_threads_equal_captures_one_by_one(pool: Simulator) -> None:
    cameras = [pool.rov.cameras["front"], pool.rov.cameras["down"], pool.cameras["station"]]
    alone = [camera.capture().rgb.tobytes() for camera in cameras]
    with ThreadPoolExecutor(6) as threads:
        together = list(threads.map(lambda camera: camera.capture().rgb.tobytes(), cameras * 2))
    assert together == alone * 2


def test_other_python_threads_run_while_a_camera_computes_its_rays() -> None:
    lens = _core.Lens(1280, 720, 900.0, 900.0, 640.0, 360.0, [-0.12, 0.02, 0.0, 0.0, 0.0])
    maker = threading.Thread(target=_core.Camera, args=("large", lens))
    turns = 0
    maker.start()
    while maker.is_alive():
        time.sleep(0.001)
        turns += 1
    assert turns > 10


def test_each_switch_lights_its_own_lamps(pool: Simulator) -> None:
    pool.set_optics(sun_elevation_deg=-6)
    rov = pool.rov

    def light(name: str) -> float:
        return float(rov.cameras[name].capture(without=["noise", "particles"], radiance=True).radiance.mean())

    assert light("front") == light("down") == 0
    rov.lamps["front"].on = True
    front = light("front")
    assert front > 10 * light("down")
    rov.lamps["down"].on = True
    assert light("down") > 1e-4
    rov.lamps["front"].on = False
    assert light("front") < front
    with pytest.raises(ValueError, match="lamp 'front': on = 3: must be True or False"):
        rov.lamps["front"].on = 3  # type: ignore[assignment]


def test_turbid_water_lowers_contrast_and_unknown_optics_are_refused(pool: Simulator) -> None:
    camera = pool.rov.cameras["front"]
    contrasts = []
    for jerlov in ("I", "III", "5C", "9C"):
        pool.set_optics(jerlov=jerlov)
        radiance = camera.capture(["attenuation", "backscatter", "sunlight", "shadows"], radiance=True).radiance[..., 1]
        contrasts.append(float(np.abs(np.diff(radiance, axis=1)).mean() / radiance.mean()))
    assert contrasts == sorted(contrasts, reverse=True)
    with pytest.raises(ValueError, match=r"jerlov.*must be one of I, IA"):
        pool.set_optics(jerlov="IV")
    with pytest.raises(ValueError, match=r"did you mean 'optics\.jerlov'"):
        pool.set_optics(jerlow="III")
    assert pool.optics.jerlov == "9C"


def test_a_visibility_scales_the_water_and_keeps_its_colour() -> None:
    sim = Simulator("pool")
    usual = core_optics(sim.optics).water
    assert sim.parameters["optics.visibility_m"] == pytest.approx(4.8 / usual.beam_attenuation[1])
    sim.parameters["optics.visibility_m"] = 2.4
    found = core_optics(sim.optics).water
    assert found.beam_attenuation[1] == pytest.approx(2.0)
    for name in ("absorption", "scattering", "diffuse_attenuation"):
        shares = getattr(found, name) / getattr(usual, name)
        assert shares == pytest.approx([shares[0]] * 3)
    sim.parameters["optics.visibility_m"] = None
    assert np.array_equal(core_optics(sim.optics).water.absorption, usual.absorption)
    with pytest.raises(ValueError, match=r"visibility_m.*must be in \[0.1, 1000\] m"):
        sim.parameters["optics.visibility_m"] = 0.0


@pytest.mark.parametrize("scenario", ["lake", "pool"])
def test_the_station_sees_the_docked_vehicle(scenario: str) -> None:
    frame = Simulator(scenario, threads=2).cameras["station"].capture(geometry_only=True)
    share = (frame.labels == frame.label_names.index("rov")).mean()
    assert share > 0.02
    above, right = np.abs(np.argwhere(frame.labels == frame.label_names.index("rov")).mean(axis=0) - (180, 320))
    assert above < 60 and right < 60, "near the middle"


def test_the_chase_camera_follows_place_and_heading_alone(pool: Simulator) -> None:
    rov, chase = pool.rov, pool.rov.cameras["chase"]
    poses = {}
    for name, euler_deg in {"level": (40, 0, 0), "tilted": (40, 35, -50), "turned": (130, 0, 0)}.items():
        rov.place((1.0, 0.5, -2.0), Rotation.from_euler("ZYX", euler_deg, degrees=True).as_quat())
        frame = chase.capture(geometry_only=True)
        assert (frame.labels == frame.label_names.index("rov")).mean() > 0.03, "it sees the vehicle that it follows"
        poses[name] = frame.world_from_camera
    np.testing.assert_allclose(poses["tilted"], poses["level"], atol=1e-12)
    quarter = np.eye(4)
    quarter[:3, :3] = Rotation.from_euler("z", 90, degrees=True).as_matrix()
    there = np.eye(4)
    there[:3, 3] = (1.0, 0.5, -2.0)
    expected = there @ quarter @ np.linalg.inv(there) @ poses["level"]
    np.testing.assert_allclose(poses["turned"], expected, atol=1e-12)
    rov.place((1.0, 0.5, -4.9))
    assert chase.capture(geometry_only=True).world_from_camera[2, 3] >= -5.0 + 0.3, "above the ground"


def test_turbulence_bends_rays_by_its_closed_form(pool: Simulator) -> None:
    """Chernov's formula: proportional to the temperature deviation; about a pixel at 2 K, zero at 0 K."""
    camera = pool.rov.cameras["front"]

    def bent_px(turbulence_k: float) -> float:
        pool.set_optics(turbulence_k=turbulence_k)
        squares: list[np.ndarray] = []
        for _ in range(4):
            pool.advance(0.5)
            with_it, without = (camera.capture(on, geometry_only=True) for on in (["wobble"], []))
            with np.errstate(invalid="ignore"):  # depths may be infinite
                slope = np.gradient(without.depth_m.astype(np.float64), axis=0)
                shift_px = (with_it.depth_m - without.depth_m) / slope
            level = (with_it.labels == 1) & (without.labels == 1) & (np.abs(slope) > 1e-4)
            squares.append(shift_px[level] ** 2)
        return float(np.sqrt(np.mean(np.concatenate(squares))))

    closed_form_px = camera.info.k[0, 0] * 1e-4 * 2.0 * np.sqrt(2 * np.sqrt(np.pi) / 3 * 5.0 / 0.05)
    assert closed_form_px > 0.7
    for turbulence_k in (0.0, 1.0, 2.0):
        assert bent_px(turbulence_k) == pytest.approx(closed_form_px * turbulence_k / 2, rel=0.35)


def test_frames_are_saved_as_png_and_jpeg(pool: Simulator, tmp_path: Path) -> None:
    frame = pool.rov.cameras["front"].capture()
    for name, most in (("a.png", 0), ("a.jpg", 4)):
        frame.save(tmp_path / name)
        assert np.abs(np.asarray(Image.open(tmp_path / name), np.float64) - frame.rgb).mean() <= most
    assert Image.open(io.BytesIO(frame.jpeg(95))).size == (640, 360)
    with pytest.raises(ValueError, match=r"must end in \.png"):
        frame.save(tmp_path / "a.gif")
    with pytest.raises(ValueError, match="quality = 0"):
        frame.jpeg(0)
    with pytest.raises(ValueError, match="only geometry"):
        pool.rov.cameras["front"].capture(geometry_only=True).png()
    assert {path.name for path in tmp_path.iterdir()} == {"a.png", "a.jpg"}


def test_effects_are_chosen_by_name_and_unknown_names_are_refused(pool: Simulator) -> None:
    camera = pool.rov.cameras["front"]
    assert camera.capture(EFFECTS).rgb.tobytes() == camera.capture("on").rgb.tobytes()
    assert camera.capture([]).rgb.tobytes() == camera.capture("off").rgb.tobytes()
    with pytest.raises(ValueError, match="effects = 'fog': must be 'on', 'off' or names of attenuation"):
        camera.capture(["fog"])
    with pytest.raises(ValueError, match="effects = 3: must be"):
        camera.capture(3)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="threads = 0: must be in"):
        camera.capture(threads=0)


def test_a_camera_below_ground_is_refused_and_one_in_a_solid_sees_its_inner_side(pool: Simulator) -> None:
    pool.rov.place((0.0, 0.0, -4.8))
    with pytest.raises(ValueError, match=r"camera 'rov/down' position_m = .*: must be above the ground"):
        pool.rov.cameras["down"].capture()
    pool.rov.place((2.4, 0.0, -4.5))  # the lens is 0.6 m ahead, hence inside the box
    frame = pool.rov.cameras["front"].capture("off")
    assert (frame.labels == frame.label_names.index("box")).all()
    assert (frame.depth_m < 1).all()


@pytest.mark.parametrize(
    ("parameters", "message"),
    [
        ("width: 0", "must be in [1, 8192] pixels"),
        ("width: 8000, height: 8000", "times its height must be at most 16.8 million pixels"),
        ("field_of_view_deg: 180", "must be in [1, 170] deg"),
        ("fov: 80", "unknown key"),
        ("distortion: [-2, 0, 0, 0, 0]", "folds"),
    ],
)
def test_impossible_cameras_are_refused(tmp_path: Path, parameters: str, message: str) -> None:
    odd = f"  dock_m: [0, 0, -2]\n  cameras: {{odd: {{position_m: [0, 0, 3], {parameters}}}}}"
    (tmp_path / "pool.yaml").write_text(POOL.read_text().replace("  dock_m: [0, 0, -2]", odd))
    with pytest.raises(ValueError, match=rf"(?s)camera.*{re.escape(message)}|{re.escape(message)}.*camera"):
        Simulator(tmp_path / "pool.yaml").cameras["odd"].capture()


@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_a_textured_mesh_shows_its_image(tmp_path: Path, suffix: str) -> None:
    image = Image.new("RGB", (64, 64), (200, 30, 30))
    image.paste((30, 30, 200), (32, 0, 64, 64))
    visual = trimesh.visual.TextureVisuals(uv=np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]]), image=image)
    corners = [[0.0, 1, 0], [0, -1, 0], [0, -1, 2], [0, 1, 2]]
    board = trimesh.Trimesh(corners, [[0, 1, 2], [0, 2, 3]], visual=visual, process=False)
    board.export(tmp_path / f"board{suffix}")
    text = POOL.read_text().replace("  - kind: box\n", f"  - kind: mesh\n    file: board{suffix}\n    up: z\n", 1)
    (tmp_path / "pool.yaml").write_text(text.replace("    size_m: [1, 1, 1]\n", ""))
    sim = Simulator(tmp_path / "pool.yaml", threads=1)
    sim.rov.place((-1.0, 0.0, -3.8))
    frame = sim.rov.cameras["front"].capture("off")
    v, u = np.nonzero(frame.labels == frame.label_names.index("box"))
    left, right = frame.rgb[v[u < 310], u[u < 310]], frame.rgb[v[u > 330], u[u > 330]]
    assert len(left) > 100 and len(right) > 100
    assert left[:, 0].mean() > 2 * left[:, 2].mean()
    assert right[:, 2].mean() > 2 * right[:, 0].mean()


def test_from_below_the_sky_is_seen_within_snells_window_only() -> None:
    world = _core.World()
    scene = _core.CameraScene(world, _core.RayScene(world), 0)
    lens = _core.Lens(201, 201, 70.0, 70.0, 100, 100)
    turn = Rotation.from_euler("ZYX", (0, -90, 0), degrees=True).as_quat()
    optics = _core.Optics(_core.WaterOptics.jerlov("I"), 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    picture = scene.render(
        _core.Camera("up", lens), optics, (0, 0, -3), turn, 0.0, 0, ["surface", "sunlight"], keep_radiance=True
    )
    v, u = np.mgrid[:201, :201]
    angle = np.degrees(np.arctan(np.hypot(u - 100, v - 100) / 70))
    light = picture.radiance[..., 2]
    assert light[(angle > 20) & (angle < 46)].min() > 3 * np.median(light[angle > 50])
