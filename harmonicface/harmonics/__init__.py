"""The sphere: harmonics, their indices, quadrature."""
