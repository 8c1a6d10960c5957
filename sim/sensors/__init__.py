"""What the simulated sensors measure of a world."""
