"""From one motion of a branch to the next: steps in energy, frequency and arc-length."""
