"""Many independent simulations of one world, stepped and read together. Arrays have one row per simulation."""

from uwsim.batch.aboard import MemberAboard
from uwsim.batch.batch import Batch
from uwsim.batch.control import BatchAutopilot, BatchController, BatchPathFollower
from uwsim.batch.results import (
    BatchEstimate,
    BatchGuidance,
    BatchJoints,
    BatchMotion,
    BatchObject,
    BatchPhysicsPings,
    BatchPings,
    BatchSamples,
)

__all__ = [
    "Batch",
    "BatchAutopilot",
    "BatchController",
    "BatchEstimate",
    "BatchGuidance",
    "BatchJoints",
    "BatchMotion",
    "BatchObject",
    "BatchPathFollower",
    "BatchPhysicsPings",
    "BatchPings",
    "BatchSamples",
    "MemberAboard",
]
