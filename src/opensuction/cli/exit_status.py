"""Exit statuses of ``opensuction``, and their description in the help."""

import signal

DONE = 0
FAILED = 1
"""Of a run that failed or was aborted; each command's help says what that is for it."""
BAD_INPUT = 2
NOT_WRITTEN = 74
"""A file, the output or the cache could not be written; ``EX_IOERR`` of ``sysexits.h``."""
SIGNALLED = 128
"""Plus the number of the signal, as shells say it."""
HUNG_UP = SIGNALLED + 1
"""As if the signal ``SIGHUP`` (1 wherever there is one) had ended it."""
PIPE_CLOSED = SIGNALLED + 13
"""As if the signal ``SIGPIPE`` (13 wherever there is one) had ended it."""
INTERRUPTED = SIGNALLED + signal.SIGINT
TERMINATED = SIGNALLED + signal.SIGTERM

EVERY = f"{BAD_INPUT} bad input, {NOT_WRITTEN} not written (disk full), {INTERRUPTED} interrupted"
"""What can happen to every command."""

IN_FULL = f"""\b
Exit status of every command:
  {DONE:3}  done
  {FAILED:3}  failed or aborted: the command's own help says what that is
  {BAD_INPUT:3}  bad input: one line says what, where, and what would be right
  {NOT_WRITTEN:3}  something could not be written, such as on a full disk
  {HUNG_UP:3}  the terminal was closed
  {INTERRUPTED:3}  interrupted (Ctrl-C)
  {PIPE_CLOSED:3}  nobody reads the output any more (a closed pipe)
  {TERMINATED:3}  terminated

From {BAD_INPUT} on stdout has no JSON; nothing is ever left half-written."""
