"""The errors a person can cause, each one plain line."""


class InputError(ValueError):
    """Bad input: unknown name, malformed file, missing, extra or impossible value.

    The message is one line that says what, where, the value, the limit with its unit, and what
    would be right. The command line prints it and exits with 2.
    """
