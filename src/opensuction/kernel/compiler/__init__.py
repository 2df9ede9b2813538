"""Compilation of core functions to machine code by numba: once for each that Python calls."""
