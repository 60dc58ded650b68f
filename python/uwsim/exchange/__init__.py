"""Files of others, coming and going: robots and worlds, charts and soundings, hulls, Unity projects, logs."""
