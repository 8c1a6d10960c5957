"""Multi-layer intensity maps along a recording, and the threshold fitted to one."""
