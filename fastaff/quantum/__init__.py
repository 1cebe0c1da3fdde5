"""Quantum mechanics of the body: spectra and wave functions on GL(2,R), L^2 with the Riemannian measure."""
