"""What is looked at of a file of somebody else before it is read."""
