"""The command line: options in, pictures and plain data out."""
