"""Many jobs in parallel: workers on this machine or on a Dask cluster, and a ledger of finished jobs."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.campaigns.workers.campaign import Campaign
    from uwsim.campaigns.workers.ledger import Ledger
    from uwsim.campaigns.workers.options import CampaignOptions, RetriedOptions
    from uwsim.campaigns.workers.work import Finished
    from uwsim.campaigns.workers.workers import Workers, open_workers

__all__ = ["Campaign", "CampaignOptions", "Finished", "Ledger", "RetriedOptions", "Workers", "open_workers"]
__getattr__ = lazy(
    __name__,
    {
        "Campaign": "campaign",
        "CampaignOptions": "options",
        "Finished": "work",
        "Ledger": "ledger",
        "RetriedOptions": "options",
        "Workers": "workers",
        "open_workers": "workers",
    },
)
