"""Writers for a dataset's files, one module per format."""
