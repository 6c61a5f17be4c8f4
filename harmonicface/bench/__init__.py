"""Speed against error: the main job, measured and reported."""
