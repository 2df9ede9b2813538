"""What the machine does: phases, transitions, the cycle and its protocol."""
