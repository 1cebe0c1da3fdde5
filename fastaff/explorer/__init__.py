"""The explorer: a page of its own in which a section is looked at by clicking on it."""
