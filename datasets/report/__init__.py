"""A recording as one page that opens anywhere."""
