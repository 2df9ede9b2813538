"""One automated cycle, with or without faults."""
