"""Compiled kernels of indicators."""
