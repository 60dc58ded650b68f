"""Many independent simulations of one world, stepped and asked together, with arrays that have a row for each."""

from uwsim.batch.batch import Batch
from uwsim.batch.results import BatchMotion, BatchPings, BatchSamples

__all__ = ["Batch", "BatchMotion", "BatchPings", "BatchSamples"]
