"""Many jobs in parallel: workers on this machine or on a Dask cluster, and a ledger of finished jobs."""

from uwsim.campaigns.workers.ledger import Ledger, run_missing
from uwsim.campaigns.workers.work import Finished, Show, Tell
from uwsim.campaigns.workers.workers import Workers, open_workers

__all__ = ["Finished", "Ledger", "Show", "Tell", "Workers", "open_workers", "run_missing"]
