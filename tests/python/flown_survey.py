"""A small survey in sloped water, flown once for files of all formats, and an independent tracer of its rays."""

from functools import cached_property
from pathlib import Path

import numpy as np

from uwsim import _core
from uwsim.flight.raw_survey import RawSurvey
from uwsim.flight.survey import run_survey
from uwsim.instruments.sonars.soundings import sound_speed_profile
from uwsim.mapping.depth_grid import depth_grid
from uwsim.recording.pings import recorded_pings
from uwsim.recording.reader import Recording
from uwsim.recording.replay import new_simulator
from uwsim.recording.survey_from import repeated, request_of

LATITUDE, LONGITUDE = 43.1, 5.9
POOL = """
name: sloped_water
earth: {latitude_deg: 43.1, longitude_deg: 5.9}
mission_time_s: 600
water: {density_kg_m3: 1000, surface_temperature_deg_c: 25, bottom_temperature_deg_c: 6}
terrain: {source: noise, size_m: [30, 30], spacing_m: 0.5, bed_depth_m: 9}
station: {position_m: [-6, 0, 0], dock_m: [0, 0, -2]}
vehicles:
  - name: rov
    model: rov
    start: station
    sonar: {model: 2, tilt_deg: 90SONAR}
survey: {area_m: [[-3, -2], [0, -2], [0, 1], [-3, 1]], altitude_m: 5, line_spacing_m: 6, speed_m_s: 0.5, tilt_deg: 90,
         ping_rate_hz: 4}
"""


class Flown:
    """A survey flown once, with its raw file and its recording.

    raw: the raw file's name. sonar, options: more of the sonar's settings and more arguments of run_survey.
    """

    def __init__(self, folder: Path, raw: str, sonar: str = "", **options) -> None:
        self.folder, self.scenario = folder, folder / "scenario.yaml"
        self.scenario.write_text(POOL.replace("SONAR", sonar))
        self.raw, self.recording = folder / raw, folder / "survey.mcap"
        options = {"report": "none", "record_topic": ("tf_static",), **options}  # all would take most of the time
        self.record = run_survey(self.scenario, folder / "out", raw=self.raw, record=self.recording, **options)

    @cached_property
    def gsf(self) -> Path:
        """Another raw file, made from the recording."""
        return self.raws_of_recording("again.gsf")[0]

    def raws_of_recording(self, *names: str, asked: tuple[dict, ...] = ({},)) -> list[Path]:
        """Write raw surveys from the recording, all at once; return their paths. asked: arguments of RawSurvey."""
        recording, paths = Recording(self.recording), [self.folder / name for name in names]
        sim = new_simulator(recording)
        raws = Several(RawSurvey(sim, path, **each) for path, each in zip(paths, asked, strict=True))
        repeated(recording, sim, request_of(recording), raw=raws)
        return paths

    @cached_property
    def own_soundings(self) -> np.ndarray:
        """The soundings (n, 3) by our own chain, in the world."""
        recording = Recording(self.recording)
        sim = new_simulator(recording)
        profile, points = sound_speed_profile(sim.world.water), []
        for taken, _ in recorded_pings(recording, "sonar_ping"):
            pose, angles = taken.odom_from_sonar, taken.ping.angles_rad.astype(float)
            axes = np.stack([np.cos(angles), np.sin(angles), 0 * angles], 1) @ pose[:3, :3].T
            times = 2.0 * taken.ping.ranges_m.astype(float) / profile.at(-pose[2, 3])
            points.append(_core.soundings(axes, times, pose[:3, 3], profile))
        found = np.concatenate(points)
        return found[np.isfinite(found).all(axis=1)]


class Several(list):
    """Raw surveys that are written as one."""

    def add(self, *taken) -> None:
        for each in self:
            each.add(*taken)

    def close(self) -> None:
        for each in self:
            each.close()


def traced_from_travel_times(swath, profile) -> np.ndarray:
    """Return the soundings of a swath, as its own, from its travel times."""
    seen = swath.is_detected
    start = np.array([*swath.transducer_m[:2], -(swath.reference_depth_m + swath.transducer_m[2])])
    ends = _core.soundings(swath.axes[seen] * [1, 1, -1], swath.travel_time_s[seen], start, profile)
    return ends * [1, 1, -1]


def traced(start_depth_m, down, time_s, depths_m, speeds_m_s, dz_m=0.01):
    """Return horizontal range and depth of each ray, by thin even layers, to a micrometre; for tests alone."""
    z = np.arange(start_depth_m, depths_m[-1], dz_m)
    c = np.interp(z + dz_m / 2, depths_m, speeds_m_s)
    sine = np.sqrt(1.0 - down**2) / np.interp(start_depth_m, depths_m, speeds_m_s)
    out = []
    for p, t in zip(sine, time_s / 2, strict=True):
        cosine = np.sqrt(np.maximum(1.0 - (p * c) ** 2, 1e-12))
        times, ranges = np.cumsum(dz_m / (c * cosine)), np.cumsum(dz_m * p * c / cosine)
        out.append((np.interp(t, times, ranges), np.interp(t, times, z + dz_m)))
    return np.array(out)


def grids_apart_m(ours: np.ndarray, theirs: np.ndarray, cell_m: float = 0.5) -> np.ndarray:
    """Return how far the depths of two sets of points (n, 3) are apart in each cell in which both have over 20."""
    mine, other = depth_grid(ours, cell_m), depth_grid(theirs, cell_m)
    west_south = np.maximum(mine.extent_m[::2], other.extent_m[::2])
    east_north = np.minimum(mine.extent_m[1::2], other.extent_m[1::2])

    def part(grid):
        column, row = np.round((west_south - [grid.west_m, grid.south_m]) / cell_m).astype(int)
        columns, rows = np.round((east_north - west_south) / cell_m).astype(int)
        return [each[row : row + rows, column : column + columns] for each in (grid.depth_m, grid.count)]

    (mine_m, count), (other_m, others) = part(mine), part(other)
    return np.abs(mine_m - other_m)[(count > 20) & (others > 20)]
