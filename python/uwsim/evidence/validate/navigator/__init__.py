"""The navigation filter: its errors held against its own covariance, in flights of many kinds."""
