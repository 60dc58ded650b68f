"""From a checked scenario to the objects of the native core: all of this conversion is here."""
