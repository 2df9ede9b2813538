"""Detection of mucus from the suction line, and the duration of suction by it."""
