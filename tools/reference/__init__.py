"""Reference pages that are generated from the code, so that they cannot be out of date."""
