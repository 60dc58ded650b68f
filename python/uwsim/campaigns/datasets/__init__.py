"""Datasets: labelled camera and sonar images, at random poses or along a track, in common formats."""

from typing import TYPE_CHECKING

from uwsim.base.lazy import lazy

if TYPE_CHECKING:
    from uwsim.campaigns.datasets.make import Dataset, make_dataset
    from uwsim.campaigns.datasets.spec import PRODUCTS

__all__ = ["PRODUCTS", "Dataset", "make_dataset"]
__getattr__ = lazy(__name__, {"PRODUCTS": "spec", "Dataset": "make", "make_dataset": "make"})
