"""Compiled kernels: arrays in, arrays and statuses out; no checks, no strings, no Python objects."""
