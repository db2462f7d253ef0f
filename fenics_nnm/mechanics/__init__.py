"""What a motion obeys: model, rest, forces, series in time; NumPy and SciPy only."""
