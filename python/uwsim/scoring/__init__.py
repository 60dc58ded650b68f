"""Comparison of a map with the ground truth: coverage, precision, recall, distances and IHO S-44 orders."""
