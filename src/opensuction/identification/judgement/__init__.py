"""How good an identified model is."""
