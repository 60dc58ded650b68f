"""Reference pages made from the program itself, so that they cannot be out of date."""
