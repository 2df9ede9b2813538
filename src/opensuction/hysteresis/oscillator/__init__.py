"""A mass on a spring, a damper and a hysteretic force, and its identification from a recording."""
