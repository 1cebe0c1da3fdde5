"""Compiled kernels of special functions and phases."""
