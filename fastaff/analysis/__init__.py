"""What is found out about orbits, one subject a folder.

Each imports only those named before it: orbits, frequencies, sections, chaos, periodic, tori.
"""
