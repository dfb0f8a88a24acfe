"""The vehicle alone, as it runs at sea."""
