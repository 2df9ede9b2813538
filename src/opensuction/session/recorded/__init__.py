"""A simulated run as a recording, and recordings played again or handed on."""
