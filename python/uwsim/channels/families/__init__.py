"""The channels by family: each file returns the channels of one, from which the table is assembled."""
