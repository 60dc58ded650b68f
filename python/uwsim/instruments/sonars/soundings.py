"""Soundings: points in the world, computed from travel times and the sound-speed profile that a survey assumes.

ping = rov.sonar.ping()                                                       # in physics mode, `bending: true`
true = sound_points(ping, sound_speed_profile(sim.world.water))               # on the bed
wrong = sound_points(ping, SoundSpeedProfile([0, 50], [1490, 1490]))          # a flat bed bends up or down at its ends
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from uwsim import _core

SoundSpeedProfile = _core.SoundSpeedProfile
sound_speed_profile = _core.sound_speed_profile

__all__ = ["SoundSpeedProfile", "beam_directions", "sound_points", "sound_speed_profile"]


def beam_directions(ping: _core.PhysicsPing | _core.Ping) -> NDArray[np.float64]:
    """Return unit vectors along the beams at transmission, (beams, 3), world; see beam_angles.h for the angles."""
    angles = ping.angles_rad.astype(np.float64)
    axes = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], axis=1)
    return np.asarray(axes @ ping.world_from_sonar[:3, :3].T, np.float64)


def sound_points(ping: _core.PhysicsPing | _core.Ping, profile: _core.SoundSpeedProfile) -> NDArray[np.float64]:
    """Return the end of each beam's ray, traced for half its travel time: (beams, 3), world, NaN without a detection.

    profile: the assumed profile; the true profile is sound_speed_profile(sim.world.water). Head motion is not corrected
    for. Raises ValueError for a ping in geometry mode, which has no travel times.
    """
    if not isinstance(ping, _core.PhysicsPing):
        raise ValueError(f"ping is a {type(ping).__name__}: must be of `mode: physics`, which has travel times")
    return _core.soundings(beam_directions(ping), ping.travel_time_s, ping.world_from_sonar[:3, 3], profile)
