"""Many jobs in parallel: workers on this machine or on a Dask cluster, and a ledger of finished jobs."""

from uwsim.campaigns.workers.ledger import Ledger
from uwsim.campaigns.workers.workers import Finished, Workers, open_workers

__all__ = ["Finished", "Ledger", "Workers", "open_workers"]
