"""Data and systems of other tools, and results on disk: what crosses the border of the package."""
