"""Quantum mechanics with the invariant metrics of section 7: on U(2), and on GL+(2,R) with affine invariance."""
