"""Estimators: model parameters from recordings."""
