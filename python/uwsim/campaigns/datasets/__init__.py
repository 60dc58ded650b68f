"""Datasets: labelled camera and sonar images, at random poses or along a track, in common formats."""

from uwsim.campaigns.datasets.make import Dataset, make_dataset
from uwsim.campaigns.datasets.spec import PRODUCTS

__all__ = ["PRODUCTS", "Dataset", "make_dataset"]
