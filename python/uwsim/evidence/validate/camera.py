"""The camera suite: pictures compared with the laws of light in water, the sonar's rays and OpenCV's projection.

Each law is measured in pictures of a small world: a grey wall, a level plate, a lamp, or the sky through the surface.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.evidence.validate.check import Check, along, relative, within
from uwsim.evidence.validate.peers import focused_light
from uwsim.evidence.validate.pictures import BANDS, NIGHT_DEG, Light, View, box_scene

TYPES = ("I", "III", "5C")


def wall_at(range_m: float, depth_m: float = 6.0) -> View:
    """Return a level view of a wall facing the camera, range_m ahead."""
    return View(box_scene((range_m + 0.5, 0, -depth_m), (1, 40, 8)), (0, 0, -depth_m))


def wall_against_range() -> list[Check]:
    """Check L(r) = L0 exp(-c r) + B (1 - exp(-c r)), c = a + b, with the wall's L0 and open water's backscatter B."""
    checks = []
    ranges = np.array([0.5, 1.0, 2.0, 4.0, 8.0, 16.0])
    for jerlov in TYPES:
        light = Light(jerlov)
        c = np.asarray(light.water.absorption) + np.asarray(light.water.scattering)
        backscatter = wall_at(2000.0).ahead(light, ["sunlight", "attenuation", "backscatter"])
        seen, own = [], []
        for r in ranges:
            view = wall_at(r)
            seen.append(view.ahead(light, ["sunlight", "attenuation", "backscatter"]))
            own.append(view.ahead(light, ["sunlight"]))
        transmitted = np.exp(-np.outer(ranges, c))
        expected = np.array(own) * transmitted + backscatter * (1 - transmitted)
        for band, name in enumerate(BANDS):
            scale = float(expected[:, band].max())
            got = np.array(seen)[:, band]
            group = f"grey wall, type {jerlov}"
            checks.append(
                along(group, name, expected[:, band], got, scale, 1e-4, x=ranges, across="distance of the wall [m]")
            )
    return checks


def sunlight_against_depth() -> list[Check]:
    """Check that the light on a level plate falls as exp(-Kd z) from the daylight that enters the water."""
    checks = []
    depths = np.array([1.0, 3.0, 6.0, 12.0, 24.0])
    for jerlov in TYPES:
        light = Light(jerlov)
        kd = np.asarray(light.water.diffuse_attenuation)
        level = np.asarray(light.optics.level_irradiance_below())
        expected = 0.5 / np.pi * level * np.exp(-np.outer(depths, kd))
        got = []
        for depth in depths:
            plate = box_scene((0, 0, -depth - 0.5), (4, 4, 1))
            got.append(View(plate, (0, 0, -depth + 0.5), (0, 90, 0)).ahead(light, ["sunlight"]))
        for band, name in enumerate(BANDS):
            ratio = np.array(got)[:, band] / expected[:, band]
            checks.append(along(f"sunlight by Kd, type {jerlov}", name, np.ones(len(depths)), ratio, 1.0, 1e-4))
    return checks


def lamp_against_distance() -> list[Check]:
    """Check that a lamp beside the camera lights a wall with I cos / d^2 exp(-c d), and exp(-c r) on the way back."""
    flux_lm, half, soft, aside = 20_000.0, 0.6, 0.5, 0.2
    light = Light("III", NIGHT_DEG)
    c = np.asarray(light.water.absorption) + np.asarray(light.water.scattering)
    mean_cosine = 0.5 * (np.cos(half) + np.cos(half * (1 - soft)))
    intensity = flux_lm / (2 * np.pi * (1 - mean_cosine)) / 1e5
    ranges = np.array([1.0, 2.0, 4.0, 8.0])
    got, expected = [], []
    for r in ranges:
        lamp = _core.SpotLamp((0, aside, -6.0), (0, 0, 0, 1), flux_lm, half, soft, (1, 1, 1))
        got.append(wall_at(r).ahead(light, ["attenuation", "lamps", "sunlight"], [lamp]))
        distance = np.hypot(r, aside)
        lit = intensity * (r / distance) / distance**2 * np.exp(-c * distance)
        expected.append(0.5 / np.pi * lit * np.exp(-c * r))
    ratio = np.array(got) / np.array(expected)
    return [
        along("lamp, 1 / d^2 and attenuation both ways", name, np.ones(len(ranges)), ratio[:, band], 1.0, 1e-3)
        for band, name in enumerate(BANDS)
    ]


def refraction_at_the_surface() -> list[Check]:
    """Check Snell's law for the sun's rays and for the edge of the window in which the sky appears from below."""
    checks = []
    for sun_deg in (15.0, 45.0, 75.0):
        optics = Light("I", sun_deg).optics
        across = float(np.hypot(*np.asarray(optics.to_sun_below_world)[:2]))
        expected = float(np.cos(np.radians(sun_deg)) / optics.water.refractive_index)
        checks.append(relative("refraction", f"sine of refraction, sun at {sun_deg:g} deg", expected, across, 1e-6))
    world = _core.World()
    sky = _core.CameraScene(world, _core.RayScene(world), 0)
    side, focal = 801, 300.0
    view = View(sky, (0, 0, -2.0), (0, -90, 0), focal, side)
    row = view.picture(Light("I", 60.0), ["surface"]).radiance[side // 2, :, 1]
    bright = np.flatnonzero(row > 0.5 * np.median(row[side // 2 - 50 : side // 2 + 50]))
    edge = np.degrees(np.arctan(0.5 * (bright[-1] - bright[0] + 1) / focal))
    critical = float(np.degrees(np.arcsin(1 / 1.333)))
    return [*checks, relative("refraction", "edge of Snell's window", critical, edge, 3e-3, "deg")]


def lake_depths() -> list[Check]:
    """Check each pixel's depth against the range along its ray as the sonar computes it, in double precision."""
    from uwsim.simulator.simulator import Simulator

    sim = Simulator("lake")
    sim.rov.place((-67.0, -52.0, -24.0))
    frame = sim.rov.cameras["front"].capture("off")
    centre, focal = frame.info.k[:2, 2], frame.info.k[0, 0]
    v, u = np.mgrid[5 : frame.info.height : 7, 3 : frame.info.width : 9].reshape(2, -1)
    directions = np.column_stack([(u - centre[0]) / focal, (v - centre[1]) / focal, np.ones(len(u))])
    lengths = np.linalg.norm(directions, axis=1)
    optical = frame.world_from_optical
    ranges = sim.scene.cast(optical[None, :3, 3], directions @ optical[:3, :3].T, 1e4).ranges_m.astype(np.float64)
    got = frame.depth_m[v, u] * lengths
    both = np.isfinite(ranges) & np.isfinite(got)
    missed = int(np.count_nonzero(np.isfinite(ranges) != np.isfinite(got)))
    error = (got[both] - ranges[both]) / np.maximum(ranges[both], 1.0)
    # A pixel on an outline may fall on either side of it.
    error = np.sort(np.abs(error))[: int(0.995 * both.sum())]
    return [
        along("depth against the sonar's rays", f"{both.sum()} rays", np.zeros(len(error)), error, 1.0, 1e-5),
        within("depth against the sonar's rays", "hits found by only one of the two", 0, missed, len(u), 5e-3),
    ]


CHECKERS = (9, 6)
"""Number of inner corners along each side."""
SQUARE_M = 0.05


def checkerboard_scene(distance_m: float) -> tuple[_core.CameraScene, Floats]:
    """Return a scene with a tilted checkerboard ahead, and the board's inner corners (n, 3) in the world."""
    columns, rows = CHECKERS[0] + 3, CHECKERS[1] + 3
    texels = 12  # interpolation blurs an edge over one texel, about three pixels, as corner finders expect
    tiles = np.add.outer(np.arange(rows), np.arange(columns)) % 2
    tiles[[0, -1]], tiles[:, [0, -1]] = 1, 1  # a white border
    image = np.kron(np.where(tiles, 235, 20).astype(np.uint8), np.ones((texels, texels), np.uint8))
    width, height = columns * SQUARE_M, rows * SQUARE_M
    turn = Rotation.from_euler("ZYX", (14, 9, 6), degrees=True)
    corners = np.array([[0, 1, -1], [0, -1, -1], [0, -1, 1], [0, 1, 1]]) * 0.5 * np.array([0, width, height])
    place = np.array([distance_m, 0.02, -3.0])
    world = _core.World()
    label = world.add_solid("board", turn.apply(corners) + place, [[0, 1, 2], [0, 2, 3]])
    scene = _core.CameraScene(world, _core.RayScene(world), 0)
    uv = np.array([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]], np.float32)
    scene.set_appearance(label, "plain", "structure", None, np.repeat(image[..., None], 3, axis=2), uv)
    j, i = np.mgrid[2 : rows - 1, 2 : columns - 1].reshape(2, -1)
    inner = np.column_stack([np.zeros(len(i)), 0.5 * width - i * SQUARE_M, 0.5 * height - j * SQUARE_M])
    return scene, turn.apply(inner) + place


def checkerboard_corners() -> list[Check]:
    """Check corners in a picture through a distorting lens against OpenCV's projectPoints. Needs OpenCV."""
    try:
        import cv2
    except ImportError:
        return []
    scene, corners_world = checkerboard_scene(0.75)
    focal, distortion = 520.0, [-0.22, 0.06, 0.001, -0.0015, 0.0]
    lens = _core.Lens(640, 480, focal, focal, 319.5, 239.5, distortion)
    light = Light("I").optics
    picture = scene.render(
        _core.Camera("check", lens), light, (0, 0, -3), (0, 0, 0, 1), 0.0, 0, ["distortion"], keep_radiance=True
    )
    # Linear light, since the transfer curve would widen white edges and thus shift the detected corners.
    linear = np.asarray(picture.radiance)[..., 1]
    grey = np.clip(linear / linear.max() * 250, 0, 255).astype(np.uint8)
    found, pixels = cv2.findChessboardCorners(grey, CHECKERS)
    if not found:
        return [within("checkerboard", "corners found", 1, 0, 1, 0.5)]
    steps = (cv2.TERM_CRITERIA_EPS | cv2.TERM_CRITERIA_MAX_ITER, 100, 1e-4)
    pixels = cv2.cornerSubPix(grey, pixels, (5, 5), (-1, -1), steps).reshape(-1, 2)
    optical = np.column_stack([-corners_world[:, 1], -(corners_world[:, 2] + 3.0), corners_world[:, 0]])
    camera = np.array([[focal, 0, 319.5], [0, focal, 239.5], [0, 0, 1]])
    expected = cv2.projectPoints(optical, np.zeros(3), np.zeros(3), camera, np.array(distortion))[0].reshape(-1, 2)
    nearest = np.linalg.norm(expected[:, None] - pixels[None], axis=2).min(axis=1)
    name = f"{len(nearest)} corners against projectPoints"
    return [along("checkerboard", name, np.zeros(len(nearest)), nearest, 1.0, 0.1, "pixels")]


def run() -> list[Check]:
    """Return all checks of the suite."""
    return [
        *wall_against_range(),
        *sunlight_against_depth(),
        *lamp_against_distance(),
        *refraction_at_the_surface(),
        *lake_depths(),
        *checkerboard_corners(),
        *focused_light.checks(),
    ]


def irradiance_variation(depth_m: float, wind_m_s: float = 5.0, jerlov: str = "IB", sun_deg: float = 50.0) -> Floats:
    """Return the standard deviation over the mean (3,) of the daylight on a level plate, as cameras show it.

    The plate is seen at twelve places and times, over some metres, in a sea without swell. No swell: only the ripples
    of the wind focus the light.
    """
    light = Light(jerlov, sun_deg)
    optics = _core.Optics(light.water, float(np.radians(sun_deg)), 0.7, wind_m_s, 0.3, 0.0, 0.0)
    plate = box_scene((0, 0, -depth_m - 0.5), (60, 60, 1))
    side, above_m = 96, min(2.4, 0.8 * depth_m)
    camera = _core.Camera("check", _core.Lens(side, side, 0.5 * side, 0.5 * side, 0.5 * (side - 1), 0.5 * (side - 1)))
    down = Rotation.from_euler("Y", 90, degrees=True).as_quat()
    shown = [
        plate.render(camera, optics, (0.7 * k, 0, above_m - depth_m), down, 5.0 * k, 0, ["sunlight", "caustics"],
                     keep_radiance=True).radiance for k in range(12)
    ]  # fmt: skip
    seen = np.array(shown, np.float64).reshape(-1, 3)
    return np.asarray(seen.std(axis=0) / seen.mean(axis=0), np.float64)
