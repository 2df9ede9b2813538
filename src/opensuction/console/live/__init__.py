"""Present state of the machine for every page, and people's requests to it."""
