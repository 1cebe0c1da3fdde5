"""Quantum chaos: Weyl's count, statistics of spacings, Husimi functions."""
