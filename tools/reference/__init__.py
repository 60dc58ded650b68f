"""Reference pages that are generated from the program itself, so that they cannot be out of date."""
