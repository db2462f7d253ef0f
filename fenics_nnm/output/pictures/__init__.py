"""Pictures of a results folder, one kind a module."""
