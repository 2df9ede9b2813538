"""Description of machine, patient and next cycle, as known before anything moves.

One-line description of a planned cycle, of the protocol in force or of a draft.
"""

import json
import math
from datetime import timedelta
from typing import Any

from opensuction import __version__
from opensuction.console.live.hub import Hub
from opensuction.console.live.row import Row, plain
from opensuction.controller.record import Settings
from opensuction.kernel.compiled import as_python
from opensuction.kernel.vocabulary import NOT_A_DEVICE, Phase, name_of
from opensuction.procedure.cycle.schedule import ScheduleMode
from opensuction.records.database import utc_time
from opensuction.report import wording
from opensuction.runtime.machine_button import PRESSABLE
from opensuction.runtime.machine_folder import About
from opensuction.safety.limits import head_cap_mm


def say(
    deepest_mm: float, back_mm: float, vacuum_mmhg: float, suction_s: float, by_contact: bool
) -> str:
    """The line. back_mm: where suction takes place by contact; infinite where it has touched.

    >>> say(48.47, 48.47, 120.0, 14.96, by_contact=False)
    'to 48.5 mm, 120 mmHg, at most 15 s suction'
    >>> say(95.0, 88.0, 120.0, 15.0, by_contact=True)
    'until the carina is touched, 95 mm at most, then back to 88 mm, 120 mmHg, at most 15 s suction'
    """
    where = f"to {_mm(deepest_mm)}"
    if by_contact:
        back = "" if math.isinf(back_mm) else f", then back to {_mm(back_mm)}"
        where = f"until the carina is touched, {_mm(deepest_mm)} at most{back}"
    # Rounded up: it is a promise.
    most_s = math.ceil(10.0 * suction_s - 1e-9) / 10.0
    return f"{where}, {vacuum_mmhg:.0f} mmHg, at most {most_s:g} s suction"


def _mm(depth_mm: float) -> str:
    return f"{round(depth_mm, 1):g} mm"


NOTICE = f"{NOT_A_DEVICE} In-silico: a digital twin"
HEAD_CAP_MM = as_python(head_cap_mm)
CARINA = "carina_mm"
"""Where it is expected, among what recordings say of a machine (`About.heading`)."""


def tell(about: About, settings: Settings, hub: Hub) -> dict[str, Any]:
    """All of it, as a page takes it."""
    limits, plan = settings.limits, settings.plan
    capabilities = hub.machine().capabilities
    return {
        "serial": about.machine.serial,
        "kind": about.machine.kind,
        "is_twin": about.machine.is_twin,
        "capabilities": capabilities._asdict(),
        "lacks": list(capabilities.lacking),
        "notice": NOTICE if about.machine.is_twin else NOT_A_DEVICE,
        "approach": about.approach,
        "patient": {"pseudonym": about.patient, "age": about.heading.get("age")},
        "anatomy": {
            "tube_end_mm": 0.0,
            "boundary_mm": plain(limits.outside_mm),
            "park_mm": plain(plan.motion.park_mm),
            "park_head_mm": plain(plan.motion.park_head_mm),
            "head_most_mm": plain(HEAD_CAP_MM(limits.tip, limits.cap_mm)),
            "target_mm": plain(_suction_mm(settings)),
            "cap_mm": plain(limits.cap_mm),
            "carina_mm": _carina_mm(about),
        },
        "protocol": _protocol(about, settings),
        "limits": {
            "vacuum_mmhg": plain(limits.vacuum_mmhg),
            "spo2_percent": plain(limits.patient.spo2_percent),
            "heart_rate_per_min": plain(limits.patient.heart_rate_per_min),
            "airway_pressure_cmh2o": [
                plain(limits.patient.airway_least_cmh2o),
                plain(limits.patient.airway_most_cmh2o),
            ],
            "is_monitored": limits.patient.monitored,
            "negative_pressure_s": plain(limits.negative_pressure_s),
            "in_airway_s": plain(limits.in_airway_s),
        },
        "plan_sentence": say_plan(settings),
        "travel_known": plan.travel_known,
        "software_version": __version__,
        "next_cycle_at": _next_cycle_at(settings, hub),
        "catheter": {
            "label": about.catheter.label,
            "size_fr": about.catheter.size_fr,
            "left_s": hub.state()["catheter_left_s"],
        },
        "requests": [
            {"ask": name, "label": button.label, "right": str(button.right)}
            for name, button in PRESSABLE.items()
        ],
        "phases": [
            {"phase": name_of(phase), **wording.phase_words(phase.name.lower())._asdict()}
            for phase in Phase
        ],
    }


def say_plan(settings: Settings) -> str:
    """Describe in one line what a start will do."""
    plan = settings.plan
    return say(
        plan.motion.target_mm,
        _suction_mm(settings),
        plan.vacuum_mmhg,
        settings.limits.negative_pressure_s,
        plan.contact.enabled,
    )


def _suction_mm(settings: Settings) -> float:
    """Planned depth of suction; by contact the deepest that is allowed."""
    plan = settings.plan
    return plan.contact.suction_mm if plan.contact.enabled else plan.motion.target_mm


def _carina_mm(about: About) -> float | None:
    """Expected depth of the carina; None where it is not known."""
    try:
        return plain(float(about.heading[CARINA]))
    except (KeyError, ValueError):
        return None


def _protocol(about: About, settings: Settings) -> dict[str, Any]:
    """The protocol as it was chosen, and what the planner has made of it."""
    try:
        chosen = json.loads(about.protocol.content)
    except ValueError:
        chosen = {}
    plan = settings.plan
    return {
        **(chosen if isinstance(chosen, dict) else {}),
        "name": about.protocol.name,
        "vacuum_mmhg": plain(plan.vacuum_mmhg),
        "suction_s": plain(settings.limits.negative_pressure_s),
        "dwell_s": plain(plan.dwell_s),
        "target_mm": plain(_suction_mm(settings)),
    }


def _next_cycle_at(settings: Settings, hub: Hub) -> str | None:
    """Time at which the next cycle is due by schedule; None where a person asks for it."""
    schedule, newest = settings.service.schedule, hub.newest()
    if schedule.mode == ScheduleMode.ON_REQUEST or newest is None:
        return None
    since_s = Row(newest[1]).number("state.core.upkeep.schedule.since_cycle_s")
    due = utc_time.now() + timedelta(seconds=max(schedule.interval_s - since_s, 0.0))
    return due.isoformat(timespec="seconds")
