"""Compiled kernels of actions and angles."""
