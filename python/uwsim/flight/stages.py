"""Names of the stages into which a flight's wall time is broken down: physics, rays, codec, conversion and so on."""

from __future__ import annotations

from uwsim.mapping.map_filler import MAPPING, VERIFICATION, WAITING

PHYSICS, RAYS, CODEC, CONVERSION, SAMPLING, MISSION = "physics", "rays", "codec", "conversion", "samples", "mission"
STAGES = (PHYSICS, RAYS, CODEC, CONVERSION, SAMPLING, MISSION, MAPPING)
AUTOSAVE, RECORDING = "autosave", "recording"  # listed only when used, like VERIFICATION
MAP_THREAD_STAGES = (MAPPING, VERIFICATION, AUTOSAVE)  # run on the map's thread, if it has one

__all__ = [
    "AUTOSAVE", "CODEC", "CONVERSION", "MAPPING", "MAP_THREAD_STAGES", "MISSION", "PHYSICS", "RAYS", "RECORDING",
    "SAMPLING", "STAGES", "VERIFICATION", "WAITING",
]  # fmt: skip
