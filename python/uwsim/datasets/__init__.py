"""Datasets: labelled pictures of cameras and sonars, drawn or along a track, in the formats that loaders read."""

from uwsim.datasets.make import Dataset, make_dataset
from uwsim.datasets.spec import PRODUCTS

__all__ = ["PRODUCTS", "Dataset", "make_dataset"]
