"""What only checks the paper: operators, matrices, rigid tops, metrics, deformation tensors. Nothing imports it."""
