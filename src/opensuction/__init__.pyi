# The library's names for type checkers: `__init__.py` loads each when it is asked for, and an
# import there would be one of every room for the layers that `make check` holds apart.

from opensuction import hysteresis as hysteresis
from opensuction.controller.configuration import Configuration as Configuration
from opensuction.kernel.errors import InputError as InputError
from opensuction.kernel.interface import NO_MONITOR as NO_MONITOR
from opensuction.kernel.interface import NO_REQUESTS as NO_REQUESTS
from opensuction.kernel.interface import Commands as Commands
from opensuction.kernel.interface import Monitor as Monitor
from opensuction.kernel.interface import Readings as Readings
from opensuction.kernel.interface import Requests as Requests
from opensuction.library.columns import read as read
from opensuction.library.fit import Fit as Fit
from opensuction.library.fit import load as load
from opensuction.library.leaderboard import Leaderboard as Leaderboard
from opensuction.library.leaderboard import leaderboard as leaderboard
from opensuction.library.run import Run as Run
from opensuction.library.run import cycle as cycle
from opensuction.library.trial_run import TrialRun as TrialRun
from opensuction.library.trial_run import trial as trial
from opensuction.library.twin import Twin as Twin
from opensuction.library.workbench import Comparison as Comparison
from opensuction.library.workbench import compare as compare
from opensuction.library.workbench import identify as identify
from opensuction.runtime.embedded_controller import Controller as Controller
from opensuction.session.embedding import controller_settings as controller_settings
from opensuction.twin.machine.fail_safe import IDLE as IDLE

__version__: str
__all__: list[str]
