"""The computer that a machine's processes run on: one port to all that they touch of it."""
