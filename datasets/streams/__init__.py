"""Streams of a recording: read, put on one clock, aligned and synchronised."""
