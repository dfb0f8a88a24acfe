"""The parameter protocol: the store, transfer, the packed file and component metadata."""
