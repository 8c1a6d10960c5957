"""Multi-layer intensity maps: what is solid, what yields and what is transparent, from LiDAR intensities (MIM)."""
