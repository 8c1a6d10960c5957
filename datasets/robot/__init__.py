"""The robot: which topic feeds which stream, and where its sensors sit."""
