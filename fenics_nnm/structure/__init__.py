"""From a study to all that is linear of its structure."""
