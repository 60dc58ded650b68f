"""Comparison of a map with the ground truth: coverage, precision, recall, distances, and the orders of IHO S-44."""
