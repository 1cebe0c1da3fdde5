"""Compiled kernels of lines, lattices and mean turns."""
