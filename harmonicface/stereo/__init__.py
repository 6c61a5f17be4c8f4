"""Images to a Surface: photometric stereo."""
