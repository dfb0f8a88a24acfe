"""Vehicles of one's own: coefficients in words, derivatives imported from published tables, configurations checked."""
