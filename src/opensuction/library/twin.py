"""The digital twin in a loop of one's own: commands of a millisecond in, readings and truth out."""

import math
from os import fspath

from opensuction.controller.configuration import Configuration
from opensuction.kernel.codegen import plain_row
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import Commands, DriveMessage, Readings
from opensuction.library.run import Name, checked_seed, text
from opensuction.machine.twin import twin_machine
from opensuction.machine.twin.twin_machine import SHOWN_READINGS
from opensuction.session.choice import CycleChoice, RigChoice
from opensuction.session.cycle import cycle_run, resolution
from opensuction.simulation import machine_side
from opensuction.simulation.closed_loop import DT_S
from opensuction.simulation.machine_side import SHOWN_COLUMNS, MachineCall
from opensuction.twin.machine import machine as machine_model
from opensuction.twin.machine.machine import Truth
from opensuction.twin.plant import PlantState

_TRUTH = [i for i, name in enumerate(SHOWN_COLUMNS) if name.startswith("truth.")]
_SHOWN_TRUTH = slice(_TRUTH[0], _TRUTH[-1] + 1)


class Twin:
    """A machine of the digital twin, with its patient, that a loop of one's own drives. In-silico.

    Same arguments, same machine as `cycle` plays, at rest with the catheter out. Drives and pump
    obey whatever they are sent: no governor stands before them. The truth is there to judge by; no
    sensor of a machine tells it. Not made for several threads.
    """

    def __init__(  # noqa: PLR0913 - what a cycle takes, each by its name
        self,
        *,
        patient: Name | None = None,
        protocol: Name | None = None,
        approach: str = "travel",
        compensation: Name = "preview",
        machine: Name | None = None,
        catheter: str | None = None,
        conduit: str | None = None,
        seed: int = 1,
        taught_mm: float | None = None,
        gap_scale: float = 1.0,
    ) -> None:
        """Draw machine and patient, and compile or load what a millisecond of them needs.

        Arguments as those of `cycle`. Of them protocol, approach, compensation and taught_mm are
        for `settings` alone. Raises InputError as `cycle` does.
        """
        choice = CycleChoice(
            rig=RigChoice(text(machine), text(patient), catheter, conduit, checked_seed(seed)),
            protocol=text(protocol),
            approach=approach,
            compensation=fspath(compensation),
            taught_mm=taught_mm,
            gap_scale=gap_scale,
        )
        prepared = cycle_run.prepare(resolution.resolve(choice))
        loop, start = prepared.loop, prepared.start
        self.settings = Configuration(loop.controller, loop.heads_mm)
        """Of the controller that `cycle` has here: ``Controller(twin.settings)``."""
        side = twin_machine.side_of(loop, choice.rig.seed)
        self._readings: Readings | None = machine_model.read(side.machine, start.machine)
        self._call = MachineCall(machine_side.begin(side, PlantState(start.machine, start.bedside)))
        self._ticks = 0

    @property
    def time_s(self) -> float:
        """Time that has been stepped, in s."""
        return self._ticks * DT_S

    @property
    def readings(self) -> Readings:
        """Readings of the sensors, as a controller gets them."""
        if self._readings is None:
            self._readings = plain_row.unpack(Readings, self._call.shown_row[SHOWN_READINGS])
        return self._readings

    @property
    def truth(self) -> Truth:
        """The truth after the last step: where tip and patient are. Raises InputError before it."""
        if self._ticks == 0:
            raise InputError("truth: there is none before the first step")
        return plain_row.unpack(Truth, self._call.shown_row[_SHOWN_TRUTH])

    def step(self, commands: Commands) -> Readings:
        """Let a millisecond pass under these commands; the readings after it.

        `IDLE` is no command at all: drives without torque, valve closed by its spring, pump off.
        Raises InputError for another type, and for a number that is none; nothing has passed then.
        """
        if not isinstance(commands, Commands):
            raise InputError(f"commands is {type(commands).__name__}: should be Commands")
        for name, value in zip(Commands._fields, commands, strict=True):
            if not math.isfinite(value):
                raise InputError(f"commands.{name} is {value}: should be a finite number")
        message = DriveMessage(commands, wanted=0, reset=False, released=self._ticks == 0)
        self._call.step(plain_row.pack(DriveMessage, message), new=True)
        self._ticks += 1
        self._readings = None
        return self.readings

    def __repr__(self) -> str:
        where = "clear" if self.readings.mouth_clear else "passed"
        return f"Twin({self.time_s:.3f} s, head {self.readings.head_mm:.1f} mm, mouth {where})"
