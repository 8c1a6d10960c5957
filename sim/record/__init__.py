"""Recordings of drives through simulated places, with their truth, as a robot's own recorder would write them."""
