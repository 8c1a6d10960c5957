"""A 12-joint quadruped in MuJoCo: body, ground contact, gaits, controller, what it measures and how it fails."""
