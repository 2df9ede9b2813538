"""Every compensator on every twin and model."""
