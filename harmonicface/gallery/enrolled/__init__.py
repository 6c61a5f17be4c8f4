"""The people of a gallery: what stands for each, and where everybody is kept, in memory or in a folder."""
