"""Systems: models, charts, formulas."""
