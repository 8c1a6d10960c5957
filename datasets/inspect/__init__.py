"""What is in a recording, as a table and as a page."""
