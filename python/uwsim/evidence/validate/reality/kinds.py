"""The two kinds of comparison with measurements."""

PREDICTED = "predicted"
"""The simulator was not given the measured value."""
AS_MEASURED = "as measured"
"""The simulator was given the measured value, or what it follows from; the check shows that it is reproduced."""
