"""The boat and the sea, on the far side of the wires."""
