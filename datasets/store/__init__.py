"""The data set on disk: its columns, its files, and what lies beside them."""
