"""From a finite-element model to a few coordinates; NumPy only."""
