"""Drives through a place: who drives, what really happens, what the robot measures of itself, and what goes wrong."""
