"""Where the catheter head is, how it moves and what it meets: sensors and motor together."""
