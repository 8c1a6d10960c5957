"""Layers shared by the networks, one a file."""
