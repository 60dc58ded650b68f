"""Many jobs in parallel: workers on this machine or on a Dask cluster, and a ledger of finished jobs."""

from uwsim.campaigns.workers.campaign import Campaign, CampaignOptions, RetriedOptions
from uwsim.campaigns.workers.ledger import Ledger
from uwsim.campaigns.workers.work import Finished
from uwsim.campaigns.workers.workers import Workers, open_workers

__all__ = ["Campaign", "CampaignOptions", "Finished", "Ledger", "RetriedOptions", "Workers", "open_workers"]
