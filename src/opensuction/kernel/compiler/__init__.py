"""How a core function becomes machine code, by way of numba: once for each that Python calls."""
