"""Assessment of identified models: confidence, diagnosis, comparison, choice."""
