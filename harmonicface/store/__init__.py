"""Named arrays on disk; knows nothing of faces."""
