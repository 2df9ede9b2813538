"""Procedure of the machine: phases, transitions, the cycle and its protocol."""
