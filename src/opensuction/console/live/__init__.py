"""What the machine is now, for all who look, and what people ask of it."""
