"""Images to a Surface: photometric stereo; known lights, unknown lamps, any unknown light, and depth each have a room."""
