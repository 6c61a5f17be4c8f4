"""Light: named lights, harmonic light, environment maps."""
