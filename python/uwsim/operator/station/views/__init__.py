"""Pictures of the cameras for the page: rendered, arrived over the link, kept as snapshots."""
