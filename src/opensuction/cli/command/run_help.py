"""Help texts of ``run`` and ``ask``."""

from opensuction.cli.completion import REQUESTS
from opensuction.kernel.disclaimer import NOT_A_DEVICE

NOTICE = f"In-silico: the machine and the patient are a digital twin. {NOT_A_DEVICE}"

RUN = (
    "The twin plays machine and patient in a process of its own, the controller runs beside it at "
    "1 kHz, a recorder writes a recording for each cycle and puts it on record, and this command "
    "looks after them: what dies is started anew, the controller never into motion. It brings the "
    "catheter out then, and waits for a person: no other cycle is started. The person who looks at "
    "the patient, gives oxygen and presses start between the cycles is simulated. Ctrl-C breaks a "
    "cycle off; the catheter comes out first. Linux only."
)
RUN_EXAMPLES = """\b
Examples:
  opensuction run                                one cycle, now
  opensuction run --patient neonate --cycles 3 --every 5
  opensuction run --patient child --preoxygenation skipped --json
  opensuction ask abort                          from another terminal: stop

\b
Files:
  /dev/shm/opensuction-UID/NAME   what the processes share, in memory
  runs/TIME-NAME/*.mcap           a recording for each cycle"""

ASK = (
    f"REQUEST is one of: {', '.join(REQUESTS)}. It is answered in the next millisecond: the button "
    "went down, or why not; what came of it, phase and alarms say. Who asked is put on record. "
    "Linux only."
)
ASK_EXAMPLES = """\b
Examples:
  opensuction ask start --who "nurse Kim"
  opensuction ask abort --name ward-3
  opensuction ask reset --json"""
