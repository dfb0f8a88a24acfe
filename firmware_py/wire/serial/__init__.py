"""Sentences of serial instruments."""
