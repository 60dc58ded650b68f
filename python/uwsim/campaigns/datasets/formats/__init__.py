"""The files of a dataset, one module for each format."""
