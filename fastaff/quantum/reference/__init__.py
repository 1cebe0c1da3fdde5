"""Operators, matrices and rigid tops of the paper, which the solvers are compared with."""
