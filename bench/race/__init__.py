"""The race: fastaff beside its peers, the same work at the same measured error. Run: make bench-peers."""
