"""The files of a dataset, one format each."""
