"""Foundation of every room: the compiled decorator, phases, readings, commands, rows, errors."""
