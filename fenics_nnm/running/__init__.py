"""A whole run, in three steps: prepare, follow, publish."""
