"""Protection of the console against the network: checks and limits that every request must pass."""
