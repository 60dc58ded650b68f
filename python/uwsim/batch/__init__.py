"""Many independent simulations of one world, stepped and read together, with one array row per simulation."""

from uwsim.batch.aboard import MemberAboard
from uwsim.batch.batch import Batch
from uwsim.batch.results import BatchMotion, BatchPhysicsPings, BatchPings, BatchSamples

__all__ = ["Batch", "BatchMotion", "BatchPhysicsPings", "BatchPings", "BatchSamples", "MemberAboard"]
