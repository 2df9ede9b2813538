"""Position, motion and load of the catheter head, from its sensors and its motor together."""
