"""Intensity maps of recordings and data sets: sweeps in, maps as arrays, pictures, messages and a page out."""
