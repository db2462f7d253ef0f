"""Motion in time of a reduced model: exact flow, shooting, stability, and what they prove."""
