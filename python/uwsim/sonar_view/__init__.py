"""Pictures of what sonars see: a multibeam's fan, a forward-looking image, a side-scan's waterfall."""
