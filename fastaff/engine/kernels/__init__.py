"""Compiled kernels of integration: drivers, steps, observers, crossings."""
