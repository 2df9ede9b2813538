"""What every room shares: the compiled decorator, phases, readings, commands, rows, errors."""
