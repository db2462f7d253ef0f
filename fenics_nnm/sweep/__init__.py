"""Many studies that differ in a few keys: planned, run, and put in one table."""
