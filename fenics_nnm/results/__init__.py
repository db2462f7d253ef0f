"""The files of a run: written durably, read back, taken up again."""
