"""Lives of a whole machine under a simulated clock: real processes, faults between their steps."""
