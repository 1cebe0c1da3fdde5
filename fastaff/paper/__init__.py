"""Checks of the paper's formulas: operators, matrices, rigid tops, metrics, deformation tensors. Nothing imports it."""
