"""The options of campaigns, which commands read without importing what works."""

from __future__ import annotations

from dataclasses import dataclass

from uwsim.base.options import Options, need, option


@dataclass(frozen=True)
class CampaignOptions(Options):
    """How the jobs of a campaign are done. Its results do not depend on these options."""

    workers: int | None = option(
        None, "Worker processes on this machine; 0: work in this process. Default: one per core.", bounds=(0, 4096, "")
    )
    scheduler: str | None = option(None, "Address of a Dask cluster to use instead, such as tcp://10.0.0.1:8786.")
    resume: bool = option(False, "Do what is missing in --out.")


@dataclass(frozen=True)
class RetriedOptions(CampaignOptions):
    """The options of a campaign whose jobs may fail."""

    retry_failed: bool = option(False, "With --resume: also repeat what failed.")

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.resume:
            need("--resume", retry_failed=self.retry_failed)
