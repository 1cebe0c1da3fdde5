"""Data and systems of other tools, and results on disk: the input and output of the package."""
