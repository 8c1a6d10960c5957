"""Rigid transforms, the camera, the ground plane and the robot's motion on it."""
