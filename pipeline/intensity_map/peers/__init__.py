"""Other ways to map obstacles, on the same grid and with the same classes, to be compared with intensity maps."""
