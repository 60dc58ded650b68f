"""A scenario from overlapping photographs: a model of structure from motion becomes the bed, its colours the water."""
