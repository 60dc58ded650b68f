"""A flight's pings as a raw survey for surveyors' software: `uwsim survey --raw`, `uwsim map from --raw`."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any, Literal

import numpy as np

from uwsim import _core
from uwsim.base.arrays import Floats
from uwsim.flight.attachment import Attachment
from uwsim.flight.raw_places import (
    ErringPoses,
    Motion,
    PatchErrors,
    RawSideScan,
    angles,
    estimated_covariance,
    level_axes,
    place_of_survey,
)
from uwsim.flight.record import FlightRecord
from uwsim.instruments.sonars.soundings import beam_directions, sound_speed_profile
from uwsim.mapping.files.swath import EPOCH_NS, SoundSpeeds, SurveyHead, Swath, SwathWriter, survey_format
from uwsim.scenario.spec.vehicle_entry import SonarSetup
from uwsim.scoring.sounding_quality import SoundingQuality
from uwsim.scoring.tpu import Uncertainties, deviations
from uwsim.simulator.simulator import Simulator

PROFILE_STEP_M = 0.5


class RawSurvey:
    """Writes each ping of the first vehicle as a swath, at the pose that its map uses; `add` is a TakePing.

    With `bending: true`, travel times are those of the ping and the file's profile is the water's. Otherwise the rays
    of the simulation are straight: the file's profile is the speed at the head's depth at the first ping, at all
    depths, and travel times follow from the ranges with it. Raises ValueError unless the scenario has a place on Earth
    and the format can be written, OSError if the file cannot be.

    errors: of installation, which the file then has. known: of the survey's instruments. pose: the poses are true, or
    those of the vehicle's estimate, whose covariance then adds to `known`, or those of an estimate in a recording,
    which keeps no covariance.
    """

    def __init__(
        self, sim: Simulator, path: Path, errors: PatchErrors | None = None, known: Uncertainties | None = None,
        pose: Literal["truth", "filter", "recorded filter"] = "truth",
    ) -> None:  # fmt: skip
        self._sim, self._path, option = sim, path, "--raw"
        self._known, self._pose = known or Uncertainties(), pose
        self.quality = SoundingQuality(sim.world, sim.scene)
        written = survey_format(path, option).write
        if written is None:
            raise ValueError(f"{option} {path}: this format is only read: pings are written as .gsf, side scan as .xtf")
        self._place = place_of_survey(sim.scenario, path, option)
        self._errors = errors
        self._poses = None if errors is None else ErringPoses(errors)
        self._write = written
        self._file: SwathWriter | None = None
        self._motion = Motion()
        self.count = 0

    @property
    def _setup(self) -> SonarSetup:
        (entry,) = (each for each in self._sim.scenario.vehicles if each.name == self._sim.rov.name)
        return entry.sonar

    @cached_property
    def _bends(self) -> bool:
        return self._setup.bending

    @cached_property
    def _water(self) -> _core.SoundSpeedProfile:
        return sound_speed_profile(self._sim.world.water)

    def add(self, ping: Any, panel: object, world_from_body: Floats, true_body: Floats | None = None) -> None:
        """Write a ping taken at a pose (4, 4). true_body: the true pose, by default the vehicle's current one."""
        true = np.asarray(self._sim.rov.pose.world_from_body if true_body is None else true_body, np.float64)
        body = np.asarray(world_from_body, np.float64)
        sonar = body @ np.linalg.inv(true) @ ping.world_from_sonar
        nominal = np.linalg.inv(body) @ sonar
        if self._poses is not None:
            body, sonar = self._poses.assumed(1e-9 * ping.time_ns, body, sonar)
        if self._file is None:
            self._head_m_s = self._water.at(max(0.0, -float(sonar[2, 3])))
            self._profile = self._water if self._bends else _core.SoundSpeedProfile.even(self._head_m_s)
            self._file = self._write(self._path, self._head(nominal))
        self._file.add(self._swath(ping, body, sonar))
        self.count += 1

    def close(self) -> None:
        """Complete the file. Raises ValueError if no ping was taken."""
        if self._file is None:
            raise ValueError(f"--raw {self._path}: no ping was taken, and nothing written")
        self._file.close()

    def discard(self) -> None:
        """Remove what was written of a flight that failed."""
        if self._file is not None:
            self._file.discard()

    def _head(self, body_from_sonar: Floats) -> SurveyHead:
        model, scenario = self._sim.rov.sonar.model, self._sim.scenario
        deepest_m = -self._sim.world.lowest_m if self._bends else 0.0
        depths_m = np.arange(0.0, max(deepest_m, 0.0) + 2.0 * PROFILE_STEP_M, PROFILE_STEP_M)
        speeds = np.array([self._profile.at(depth) for depth in depths_m])
        # A head that looks straight down with its fan across the track is mounted without rotation.
        axes = body_from_sonar[:3, :3] @ np.array([[0, 0, 1], [0, -1, 0], [1, 0, 0]], np.float64)
        roll, pitch, yaw = angles(axes * np.array([1.0, -1.0, -1.0]))
        rays = "bent by the profile" if self._bends else "straight: the profile is one speed"
        errors = f"; made with errors of installation: {self._errors}" if self._errors else ""
        known = f"; standard deviations of instruments: {self._known}" if str(self._known) else ""
        pose = "; errors without those of the estimated pose" if self._pose == "recorded filter" else ""
        comment = f"uwsim: scenario {scenario.name}, seed {self._sim.seed}; simulated, rays {rays}"
        return SurveyHead(
            vehicle=self._sim.rov.name, sonar=model.name, frequency_hz=model.frequency_hz, beams=model.beams,
            max_range_m=model.range_max_m, offset_m=body_from_sonar[:3, 3] * np.array([1.0, -1.0, -1.0]),
            mount_rad=np.array([roll, -pitch, -yaw]), profile=SoundSpeeds(depths_m, speeds),
            comment=f"{comment}{errors}{known}{pose}",
        )  # fmt: skip

    def _swath(self, ping: Any, body: Floats, sonar: Floats) -> Swath:
        position = body[:3, 3]
        latitude, longitude = self._place.degrees(position).tolist()
        roll, pitch, yaw = angles(body[:3, :3])
        level = level_axes(yaw)
        north_rad = self._place.north_rad(position)
        ranges = np.asarray(ping.ranges_m, np.float64)
        axes_world = beam_directions(ping) @ (sonar[:3, :3] @ ping.world_from_sonar[:3, :3].T).T
        time_s = getattr(ping, "travel_time_s", None)
        if not self._bends:
            time_s = 2.0 * ranges / self._head_m_s
        elif time_s is None:  # a recording holds ranges: the speed at the head times half the travel time
            time_s = 2.0 * ranges / self._water.at(max(0.0, -float(ping.world_from_sonar[2, 3])))
        time_s = np.where(np.isfinite(ranges), np.asarray(time_s, np.float64), np.nan)
        ends = _core.soundings(axes_world, time_s, sonar[:3, 3], self._profile)
        soundings = (ends - position) @ level.T
        soundings[:, 2] = -ends[:, 2]
        vertical, horizontal = _deviations(ping)
        with np.errstate(invalid="ignore", divide="ignore"):
            quality = np.asarray(getattr(ping, "deviation_m", vertical), np.float64) / ranges
        kinds = getattr(ping, "detections", None)
        speed_m_s, course = self._motion.since_last(ping.time_ns, position, math.pi / 2 - yaw)
        swath = Swath(
            time_ns=EPOCH_NS + ping.time_ns, latitude_deg=latitude, longitude_deg=longitude,
            reference_depth_m=-float(position[2]), heading_rad=(math.pi / 2 - yaw + north_rad) % math.tau,
            pitch_rad=-pitch, roll_rad=roll, course_rad=(course + north_rad) % math.tau, speed_m_s=speed_m_s,
            sound_speed_m_s=self._profile.at(max(0.0, -float(sonar[2, 3]))),
            transducer_m=level @ (sonar[:3, 3] - position), travel_time_s=time_s, axes=axes_world @ level.T,
            sounding_m=soundings, beam_rad=np.asarray(ping.angles_rad, np.float64),
            amplitude_db=np.asarray(ping.intensity_db, np.float64), vertical_deviation_m=vertical,
            horizontal_deviation_m=horizontal, quality=quality,
            is_phase=np.zeros(len(ranges), bool) if kinds is None else np.asarray(kinds) == int(_core.Detection.PHASE),
        )  # fmt: skip
        pose = estimated_covariance(self._sim.rov, body, level) if self._pose == "filter" else None
        vertical, horizontal = (
            np.where(each > 0.0, each, np.nan) for each in deviations(swath, self._known, pose)
        )  # 0: none is known
        is_whole = self._pose != "recorded filter"
        self.quality.add(ends, vertical if is_whole else np.full_like(vertical, np.nan), horizontal)
        return replace(swath, vertical_deviation_m=vertical, horizontal_deviation_m=horizontal)


def _deviations(ping: Any) -> tuple[Floats, Floats]:
    """Return the vertical and horizontal standard deviations, nan where unknown."""
    vertical = getattr(ping, "vertical_deviation_m", None)
    if vertical is None:
        unknown = np.full(len(ping.ranges_m), np.nan)
        return unknown, unknown
    both = (np.asarray(each, np.float64) for each in (vertical, ping.horizontal_deviation_m))
    first, second = (np.where(np.isfinite(each), each, np.nan) for each in both)
    return first, second


class RawFlight(Attachment):
    """Writes the raw survey of one flight."""

    def __init__(self, survey: RawSurvey | RawSideScan) -> None:
        self._survey, self._has_ended = survey, False
        self.on_ping = survey.add

    def ended(self, flown: FlightRecord) -> FlightRecord:
        """Note that the flight has ended by itself or by Ctrl-C, so that its file is kept."""
        self._has_ended = True
        return replace(flown, soundings=getattr(self._survey, "quality", None))

    def try_close(self) -> OSError | None:
        """Complete the file, or remove it after a flight that failed or took no ping."""
        if not self._has_ended or self._survey.count == 0:
            self._survey.discard()
            return OSError("--raw: no ping was taken, and nothing written") if self._has_ended else None
        try:
            self._survey.close()
        except OSError as error:
            return error
        return None


def raw_writer(
    sim: Simulator, path: Path, errors: PatchErrors | None = None, known: Uncertainties | None = None,
    pose: Literal["truth", "filter"] = "truth",
) -> RawSurvey | RawSideScan:  # fmt: skip
    """Return what writes the first vehicle's multibeam or side scan, by the path's format; see RawSurvey.

    Raises ValueError.
    """
    found = survey_format(path, "--raw")
    if found.side_scan is None:
        return RawSurvey(sim, path, errors, known, pose)
    for option, given in (("--uncertainty", known), ("--offsets", errors)):
        if given is not None:
            raise ValueError(f"{option}: is of a multibeam's soundings, of which {path.suffix} has none")
    return RawSideScan(sim, path, found.side_scan)
