"""Self-calibration between cycles: what a cycle taught, carried into the next one.

What it shows is in `identification.estimator`: contact and the barrier at the tube's mouth.

The compensation learns, the governor does not: see docs/decisions/0007.

A person teaches the travel length on the twin: hand, machine and controller in the loop.

What is taught is 2 to 4 mm deeper than the carina: the hand presses until it has reacted, and the
model is 1 mm off the plant. Protocols stop that much nearer to it than their 10 mm.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from opensuction.control import compensation
from opensuction.control.compensation import CompensationKind
from opensuction.controller import calibration, setup
from opensuction.controller.calibration import Calibration
from opensuction.controller.machine_profile import MachineProfile
from opensuction.controller.record import Settings
from opensuction.identification.estimator import gap_measurement
from opensuction.identification.estimator.adaptation import Evidence, Spoilt
from opensuction.kernel.errors import InputError
from opensuction.kernel.interface import CONFIRM, NO_REQUESTS, TEACH
from opensuction.kernel.vocabulary import RESTING, Phase
from opensuction.procedure.cycle.teaching import Taught
from opensuction.procedure.planning import guideline
from opensuction.procedure.planning.guideline import GUIDELINES
from opensuction.procedure.planning.protocol import Protocol, Site
from opensuction.safety import limits
from opensuction.simulation import closed_loop, trace
from opensuction.simulation import rig as rigs
from opensuction.simulation.closed_loop import COLUMNS, DT_S, Loop, LoopState
from opensuction.simulation.rig import Rig
from opensuction.simulation.trace import Columns
from opensuction.twin.machine import dc_axis, transmission

TEACHING_RUN = 3
"""Number of the noise stream and of the person; identification and cycles have others."""
LIMIT_S = 90.0
"""No teaching lasts longer: the governor's time in the airway ends it before."""
FINE_S = 0.02
"""How finely in time the button is pressed."""


class Teaching(NamedTuple):
    """Result of a teaching."""

    taught: Taught
    taught_mm: float
    """Taught length; nan where none was taken."""
    columns: Columns
    home: bool
    """Whether the machine is parked again."""


def assemble(chosen: Rig, calibration: Calibration) -> tuple[Loop, LoopState]:
    """Closed loop of a rig ready to be taught, a person at the catheter head.

    Depth is limited by the plausible range, for the carina is not known yet, and time in the
    airway by the guideline; no cycle can be started.
    """
    age = chosen.site.age
    loop, state = rigs.assemble(
        chosen,
        guideline.protocol(age, guideline.IDLE_VACUUM_MMHG),
        CompensationKind.EXACT_INVERSE,
        calibration,
        TEACHING_RUN,
    )
    settings = loop.controller
    limits = settings.limits._replace(in_airway_s=GUIDELINES[age].in_airway_s)
    plan = settings.plan._replace(travel_known=False)
    person = dc_axis.draw_hand(
        settings.parked.head_mm, -chosen.site.park_mm, chosen.seed, TEACHING_RUN
    )
    return (
        loop._replace(
            controller=settings._replace(limits=limits, plan=plan),
            machine=loop.machine._replace(hand=person),
        ),
        state._replace(machine=state.machine._replace(hand=dc_axis.PUSHING)),
    )


def teach(chosen: Rig, calibration: Calibration, names: Sequence[str] = ()) -> Teaching:
    """The travel length that a person teaches on a rig, and how it went.

    calibration: the controller's model of the transmission, found before. names: the columns of
    the trace that are wanted.
    """
    loop, state = assemble(chosen, calibration)
    table = np.empty((trace.RECORDED_ROWS, len(COLUMNS)))
    parts, confirmed, requests = [], False, TEACH
    while state.tick * DT_S < LIMIT_S:
        left_s = dc_axis.confirms_in_s(loop.machine.hand, state.machine.hand)
        if left_s <= 0.0 and not confirmed:
            requests, confirmed = CONFIRM, True
        # Not beyond the instant at which the button may be pressed.
        ahead_s = LIMIT_S if confirmed else min(left_s, LIMIT_S)
        piece = round(max(ahead_s // FINE_S - 1.0, 1.0) * FINE_S / DT_S)
        state, ticks = closed_loop.run(loop, state, requests, table[:piece])
        requests = NO_REQUESTS
        parts.append(trace.copy_columns(table[:ticks], names))
        if state.controller.core.procedure.phase in RESTING:
            break
    found = state.controller.core.procedure.teaching
    taken = found.taught == Taught.TAKEN
    return Teaching(
        taught=Taught(found.taught),
        taught_mm=float(found.taught_mm) if taken else float(np.nan),
        columns=trace.join(parts),
        home=state.controller.core.procedure.phase == Phase.PARKED,
    )


PARKING_S = 1.0
"""Time in which a parked head goes to its new park position; a few mm take .2 s."""
COUGH_S = 0.5
"""A cough that began so long before the contact still moves the carina; assumed."""
PARKING_STEPS = 5
"""Steps towards a park position: the first is exact but for the curvature."""
PARKED_MM = 0.001
"""By so much the tip parks farther out than would just do."""


def with_widths(chosen: Rig, scale: float = 1.0, shift_mm: float = 0.0) -> Rig:
    """The same machine, its conduit routed otherwise behind the controller's back.

    Every gap width is multiplied and then enlarged. The drawn values keep what was drawn.
    """
    moved = transmission.widen(chosen.machine.transmission, scale)
    widths = transmission.bundle(max(width + shift_mm, 0.0) for width in moved.widths_mm)
    moved = moved._replace(widths_mm=widths)
    return chosen._replace(machine=chosen.machine._replace(transmission=moved))


def with_offset(chosen: Rig, deeper_mm: float) -> Rig:
    """The same machine, its catheter clamped anew behind the controller's back: the tip is deeper.

    The drawn values keep what was drawn.
    """
    transmission = chosen.machine.transmission
    moved = transmission._replace(offset_mm=transmission.offset_mm + deeper_mm)
    return chosen._replace(machine=chosen.machine._replace(transmission=moved))


def seen(
    profile: MachineProfile,
    kind: CompensationKind,
    identified: Calibration,
    mouth_mm: float,
    columns: Columns,
    cough_cmh2o: float = math.inf,
) -> Evidence:
    """Evidence on the transmission in a recorded cycle: switch, barrier, encoder, airway pressure.

    kind: whose model the barrier is read by. identified: as the laser found it. mouth_mm: depth of
    the barrier, infinite where there is none. cough_cmh2o: a pressure above it is a cough.
    """
    head_mm = columns["readings.head_mm"]
    clear, by_lines = columns["readings.mouth_clear"], kind == CompensationKind.MODEL_PREVIEW
    passed = calibration.passed(identified, clear, head_mm, mouth_mm, DT_S, by_lines)
    if not np.any(columns["phase"] == Phase.BACKING_OFF):
        return passed
    moving = np.isin(columns["phase"], (Phase.INSERTING, Phase.BACKING_OFF))
    touched = gap_measurement.find_contact(
        columns["readings.contact_closed"][moving],
        head_mm[moving],
        DT_S,
        profile.contact_latency_s,
    )
    if touched is None:
        return passed
    scale = gap_measurement.estimate_scale(identified.plays, touched, gap_measurement.TRUSTED)
    spoilt = Spoilt.NOTHING if touched.steady else Spoilt.UNSTEADY
    if _is_coughing(columns, moving, cough_cmh2o):
        spoilt = Spoilt.COUGHED
    return passed._replace(contact_scale=scale, spoilt=spoilt)


def _is_coughing(columns: Columns, moving: npt.NDArray[np.bool_], cough_cmh2o: float) -> bool:
    """True where the patient coughed around a contact. moving: ticks that are looked at."""
    touching = np.flatnonzero(moving & (columns["readings.contact_closed"] > 0.0))
    around = slice(max(int(touching[0]) - round(COUGH_S / DT_S), 0), int(touching[-1]) + 1)
    known = columns["readings.monitor.airway_pressure_valid"][around] > 0.0
    pressure = columns["readings.monitor.airway_pressure_cmh2o"][around]
    return bool(np.any(known & (pressure > cough_cmh2o)))


def parking_mm(
    profile: MachineProfile,
    kind: CompensationKind,
    used: Calibration,
    park_mm: float,
    held_head_mm: float,
) -> float:
    """Park position of the tip on a learned transmission, the head no farther in than it was.

    park_mm: where it parked. held_head_mm: head there on the identified transmission. With a gap
    that is narrower the head would come farther in; the tip parks as much farther out instead.
    """
    chosen, heads_mm = setup.compensator(profile, kind, used), setup.branches(kind, used)
    for _ in range(PARKING_STEPS):
        too_far_mm = compensation.rest(chosen, heads_mm, park_mm).head_mm - held_head_mm
        if too_far_mm <= 0.0:
            break
        park_mm -= used.model.slope * too_far_mm + PARKED_MM
    return park_mm


def replanned(
    profile: MachineProfile,
    protocol: Protocol,
    kind: CompensationKind,
    used: Calibration,
    by_contact: bool,
    site: Site,
    identified: Settings,
) -> Settings:
    """Settings of the same protocol for a learned calibration; see `bounded`.

    identified: as they were made from the identified one. Raises InputError where the protocol
    cannot be done within the limits of those.
    """
    park_mm = parking_mm(profile, kind, used, site.park_mm, identified.parked.head_mm)
    planned = setup.settings(
        profile, protocol, kind, used, by_contact, site._replace(park_mm=park_mm)
    )
    # The planner took the cap on the head from the learned gap.
    highest_mm = float(limits.head_cap_mm(identified.limits.tip, identified.limits.cap_mm))
    setup.check_cap(planned.compensation, setup.branches(kind, used), protocol, highest_mm)
    return bounded(planned, identified)


def bounded(learned: Settings, identified: Settings) -> Settings:
    """Settings for a learned transmission, held by the governor's limits of the identified one.

    learned, identified: of the same protocol on the same machine. Of the limits only the position
    where a forced withdrawal ends may move, and only farther out.
    Raises InputError where the head would park so far in that the governor could not take the tip
    to be outside.
    """
    held = identified.limits
    parked_mm = learned.limits.park_head_mm
    deepest_mm = limits.deepest_mm(held.tip, limits.assume_anywhere(held.tip, parked_mm))
    if deepest_mm > held.outside_mm:
        raise InputError(
            f"the head would park at {parked_mm:.1f} mm on the learned gap, where the tip may be "
            f"at {deepest_mm:.1f} mm, and outside the patient ends at {held.outside_mm:.1f} mm: "
            "calibrate the machine anew"
        )
    return learned._replace(
        limits=held._replace(park_head_mm=min(held.park_head_mm, parked_mm)),
    )


def parked_anew(loop: Loop, state: LoopState) -> LoopState:
    """A parked loop under new settings: it begins again from a retract to where its head is."""
    settings = loop.controller
    here = settings.parked._replace(head_mm=state.controller.core.governor.last.head_mm)
    head = compensation.park(settings.compensation, here)
    core = state.controller.core
    # The tip may park elsewhere: what is asked of it would else be where it parked before.
    procedure = core.procedure._replace(reference_mm=settings.plan.motion.park_mm)
    controller = state.controller._replace(
        compensation=head, core=core._replace(procedure=procedure)
    )
    state = state._replace(controller=controller)
    return closed_loop.run(loop, state, NO_REQUESTS, trace.rows(PARKING_S))[0]
