"""Images to a Surface: photometric stereo; known lights, unknown lamps, any unknown light, depth: a room each."""
