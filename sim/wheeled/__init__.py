"""A fast skid-steered robot: how it rolls, what it measures of itself, and how it fails."""
