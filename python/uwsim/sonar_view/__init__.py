"""Pictures of what sonars see: a multibeam's fan, a forward-looking sonar's image, a side-scan's waterfall, profiles."""
