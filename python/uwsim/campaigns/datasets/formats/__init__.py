"""Writers for the files of a dataset, one module per format."""
