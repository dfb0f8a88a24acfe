"""The tuning study: gains of both kinds of law, searched by the same optimiser on the nominal vehicle."""
