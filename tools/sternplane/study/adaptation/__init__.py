"""The adaptation study: what the vehicle gains by designing its laws from what it learns."""
