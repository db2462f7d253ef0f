"""The Python face: what `import fenics_nnm as nnm` offers, over what the commands use."""
