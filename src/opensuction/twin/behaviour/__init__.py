"""What patients do of their own accord: cough, breathe, move; and what the oximeter makes of it."""
