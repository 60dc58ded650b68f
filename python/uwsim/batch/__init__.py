"""Many independent simulations of one world, stepped and read together. Arrays have one row per simulation."""

from uwsim.batch.aboard import MemberAboard
from uwsim.batch.batch import Batch
from uwsim.batch.results import (
    BatchEstimate,
    BatchJoints,
    BatchMotion,
    BatchObject,
    BatchPhysicsPings,
    BatchPings,
    BatchSamples,
)

__all__ = [
    "Batch",
    "BatchEstimate",
    "BatchJoints",
    "BatchMotion",
    "BatchObject",
    "BatchPhysicsPings",
    "BatchPings",
    "BatchSamples",
    "MemberAboard",
]
