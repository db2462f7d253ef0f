"""Fields of a motion on its mesh: stresses, and the files that ParaView reads."""
