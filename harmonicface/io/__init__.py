"""Files to linear arrays and back; nothing else in the package opens pixels."""
