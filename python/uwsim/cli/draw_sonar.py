"""Drawing for `uwsim scenario sonar`: pings of a vehicle's multibeam and of imaging sonars from one pose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import cast

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from uwsim import _core
from uwsim.cli.pose_option import chosen_vehicle, place_as_typed
from uwsim.figures.sonar_fan import SECTION_IN, WIDTH_IN, beam_ends_m, draw_plan, draw_section
from uwsim.figures.sonar_panels import draw_image, draw_profiles, draw_waterfall
from uwsim.figures.style import label_axes, new_figure, save_figure
from uwsim.instruments.sonars import imaging
from uwsim.instruments.sonars.fan_plot import draw_water_column
from uwsim.instruments.sonars.imaging import ForwardLooking, SideScan, SingleBeam
from uwsim.simulator.simulator import Simulator
from uwsim.simulator.vehicle import Vehicle

KINDS = ("all", "fan", "image", "side-scan", "profile", "water-column")
IMAGE_TILT_DEG = 12.0  # nose down, so that the imaging sonar's aperture covers 2 to 22 degrees below horizontal
TRACK_M, PING_SPACING_M = 60.0, 0.15
PROFILE_HALF_DEG, PROFILE_STEP_DEG = 60.0, 0.9  # half the beam's width
PROFILE_REACH_M, PROFILE_BIN_M = 50.0, 0.01
WATERFALL_IN = 5.8  # height of the side-scan panel: 60 m along and 100 m across the track at the same scale
GAP_IN = 1.3  # between panels, for titles and legends


@dataclass(frozen=True)
class Request:
    """The options of `uwsim scenario sonar`: what to draw, and from which pose."""

    scenario: str | Path
    out: Path
    pose: str | None = None
    kind: str = "all"
    sonar_model: int | str | None = None
    tilt_deg: float | None = None
    track_m: float = TRACK_M
    seed: int | None = None
    frequency_hz: float | None = None
    vehicle: str | None = None


def run_sonar(request: Request) -> list[str]:
    """Draw the requested panels; return a summary as lines. Raises ValueError, OSError; leaves no incomplete file."""
    if request.kind not in KINDS:
        raise ValueError(f"--kind {request.kind}: must be one of {', '.join(KINDS)}")
    _require_picture(request.out)
    if not (np.isfinite(request.track_m) and PING_SPACING_M <= request.track_m <= 1000.0):
        raise ValueError(f"--track {request.track_m:g} m: must be in [{PING_SPACING_M:g}, 1000] m")
    if request.tilt_deg is not None and not abs(request.tilt_deg) <= 90.0:
        raise ValueError(f"--tilt {request.tilt_deg:g} deg: must be in [-90, 90] deg")
    sim = Simulator(
        request.scenario, seed=request.seed, sonar_model=request.sonar_model, sonar_frequency_hz=request.frequency_hz
    )
    rov = chosen_vehicle(sim, request.vehicle)
    if not rov.sonars:
        raise ValueError(f"vehicle '{rov.name}': has no sonar")
    if request.pose is not None:
        place_as_typed(rov, request.pose)
    if request.tilt_deg is not None:
        rov.sonar.aim(-np.radians(request.tilt_deg))
    _require_in_the_water(sim, rov)
    if request.kind in ("all", "side-scan"):
        _ahead(rov)
    figure, summary = _Sheet(sim, request).draw()
    save_figure(figure, request.out)
    return [*summary, str(request.out)]


def _require_picture(out: Path) -> None:
    """Check the output path before anything is computed."""
    if out.suffix.lower() != ".png":
        raise ValueError(f"--out {out}: must end in .png")
    if out.is_dir() or not out.parent.is_dir():
        raise OSError(f"--out {out}: " + ("is a folder" if out.is_dir() else f"there is no folder '{out.parent}'"))


def _require_in_the_water(sim: Simulator, rov: Vehicle) -> None:
    """Raise ValueError if the sonar's head is in the air or under the ground, where it receives no echo."""
    x, y, z = (float(value) for value in rov.sonar.ping().world_from_sonar[:3, 3])
    if z > 0.0:
        raise ValueError(f"the sonar's head is at z = {z:.2f} m: must be in the water, at or below 0")
    bed = float(sim.world.height_at([[x, y]])[0])
    if z < bed:
        raise ValueError(f"the sonar's head is at z = {z:.2f} m, under the bed, which is at {bed:.2f} m there")


def _ahead(rov: Vehicle) -> NDArray[np.float64]:
    """Return the vehicle's horizontal heading (3,). Raises ValueError if it points straight up or down."""
    ahead = rov.pose.world_from_body[:3, 0] * (1.0, 1.0, 0.0)
    length = float(np.linalg.norm(ahead))
    if not length > 1e-6:
        raise ValueError("a side-scan's track needs a heading: the vehicle points straight up or down")
    return np.asarray(ahead / length, np.float64)


class _Sheet:
    """Panels in one or two columns, each WIDTH_IN wide, from top to bottom; saving crops the figure to its content."""

    def __init__(self, sim: Simulator, request: Request) -> None:
        self._sim = sim
        self._rov = chosen_vehicle(sim, request.vehicle)
        self._around = sim.around(self._rov.name)
        self._request = request
        self._figure = new_figure(WIDTH_IN, WIDTH_IN)
        self._summary: list[str] = []

    def draw(self) -> tuple[Figure, list[str]]:
        """Draw the requested panels; return the figure and a summary as lines."""
        kind = self._request.kind
        right, left_in, right_in = (1 if kind == "all" else 0), 0.0, 0.0
        if kind in ("all", "fan"):
            left_in = self._fan()
        if kind == "water-column":
            self._water_column()
        if kind in ("all", "profile"):
            left_in = self._profile(left_in)
        if kind in ("all", "image"):
            right_in = self._image(right)
        if kind in ("all", "side-scan"):
            self._side_scan(
                right, right_in, max(left_in - GAP_IN - right_in, WATERFALL_IN) if kind == "all" else WATERFALL_IN
            )
        return self._figure, self._summary

    def _axes(self, column: int, top_in: float, height_in: float) -> Axes:
        left = column * (WIDTH_IN + 1.6)
        return self._figure.add_axes((left / WIDTH_IN, -(top_in + height_in) / WIDTH_IN, 1.0, height_in / WIDTH_IN))

    def _fan(self) -> float:
        sonar = self._rov.sonar
        ping = sonar.ping()
        ends_m, echo = beam_ends_m(ping, sonar.model.range_max_m)
        plan = self._axes(0, 0.0, 1.0)
        height_in = draw_plan(self._figure, plan, self._sim.world, ping, ends_m, echo)
        plan.set_position((0.0, -height_in / WIDTH_IN, 1.0, height_in / WIDTH_IN))
        draw_section(self._axes(0, height_in + GAP_IN, SECTION_IN), self._sim.world, ping, ends_m, echo)
        nearest = f", {ping.ranges_m.min():.2f} to {ping.ranges_m[ping.valid].max():.2f} m" if ping.valid.any() else ""
        self._summary.append(f"fan: {sonar.model.name}: {int(ping.valid.sum())} echoes of {len(echo)} beams{nearest}")
        return height_in + GAP_IN + SECTION_IN + GAP_IN

    def _water_column(self) -> None:
        """Draw the level of every range sample of every beam."""
        sonar = self._rov.sonar
        if sonar.mode != "physics":
            raise ValueError(f"--kind water-column: vehicle '{self._rov.name}' has its sonar in geometry mode")
        ping = cast(_core.PhysicsPing, sonar.ping(water_column=True))
        axes = self._axes(0, 0.0, WIDTH_IN)
        height_in = WIDTH_IN * draw_water_column(axes, ping)
        axes.set_position((0.0, -height_in / WIDTH_IN, 1.0, height_in / WIDTH_IN))
        label_axes(axes, "Water column", "to starboard [m]", "along the sonar's axis [m]")
        beams, samples = np.shape(ping.water_column)
        self._summary.append(f"water-column: {sonar.model.name}: {beams} beams x {samples} samples")

    def _profile(self, top_in: float) -> float:
        """Draw a pencil beam's profile across the track, on both sides of nadir."""
        model = SingleBeam(range_max_m=PROFILE_REACH_M, range_bins=round(PROFILE_REACH_M / PROFILE_BIN_M))
        body, head = self._rov.pose.world_from_body, self._rov.sonar.ping().world_from_sonar[:3, 3]
        pose = imaging.pose_matrix(head, yaw_rad=np.arctan2(body[1, 0], body[0, 0]), pitch_rad=np.pi / 2)
        angles = np.radians(np.arange(-PROFILE_HALF_DEG, PROFILE_HALF_DEG + 1e-6, PROFILE_STEP_DEG))
        profiles = imaging.profile(self._around, pose, angles, model)
        aside = np.linspace(-PROFILE_REACH_M, PROFILE_REACH_M, 800)
        bed = self._sim.world.height_at(head[:2] - aside[:, None] * pose[:2, 1]) - head[2]
        echo = np.isfinite(profiles.ranges_m)
        found_m = profiles.ranges_m[echo] * np.cos(profiles.angles_rad[echo])
        depth_m = 1.3 * float(found_m.max()) if echo.any() else PROFILE_REACH_M
        draw_profiles(self._axes(0, top_in, SECTION_IN), profiles, np.stack([aside, bed], axis=1), depth_m)
        self._summary.append(f"profile: {model.frequency_hz / 1e3:.0f} kHz, {echo.sum()} echoes of {len(angles)} pings")
        return top_in + SECTION_IN + GAP_IN

    def _image(self, column: int) -> float:
        tilt_deg = IMAGE_TILT_DEG if self._request.tilt_deg is None else self._request.tilt_deg
        model = ForwardLooking()
        head = self._rov.sonar.ping().world_from_sonar[:3, 3]
        pose = self._rov.pose.world_from_body @ imaging.pose_matrix(pitch_rad=np.radians(tilt_deg))
        pose[:3, 3] = head
        image = imaging.look_ahead(self._around, pose, model)
        axes = self._axes(column, 0.0, 1.0)
        height_in = WIDTH_IN * draw_image(axes, image)
        place = axes.get_position()
        axes.set_position((place.x0, -height_in / WIDTH_IN, 1.0, height_in / WIDTH_IN))
        self._summary.append(
            f"image: {model.frequency_hz / 1e3:.0f} kHz, {model.beams} beams x {model.range_bins} ranges to "
            f"{model.range_max_m:g} m, {tilt_deg:g} deg nose down"
        )
        return height_in + GAP_IN

    def _side_scan(self, column: int, top_in: float, height_in: float) -> None:
        body, ahead = self._rov.pose.world_from_body, _ahead(self._rov)
        pings = max(round(self._request.track_m / PING_SPACING_M), 1)
        track = np.repeat(body[None], pings, axis=0)
        track[:, :3, 3] += np.arange(pings)[:, None] * PING_SPACING_M * ahead
        waterfall = imaging.look_aside(self._around, track, SideScan())
        draw_waterfall(self._axes(column, top_in, height_in), waterfall, PING_SPACING_M)
        bottom = np.isfinite(waterfall.altitude_m)
        over = f", {np.median(waterfall.altitude_m[bottom]):.2f} m above the bed" if bottom.any() else ", no bottom"
        self._summary.append(f"side-scan: {pings} pings over {pings * PING_SPACING_M:g} m straight ahead{over}")
