"""The console as a process: ``python -m opensuction.console.console_process DIR``."""
