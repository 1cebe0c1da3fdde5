"""Models from a line of mathematics: grammar, reduction to invariants, derivatives, source text and its cache.

SymPy is imported inside functions, and only when a formula is seen for the first time: its source text is kept beside
the compiled kernels.
"""
