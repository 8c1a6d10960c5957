"""Pages, drawings and videos that every command makes alike."""
