"""Reasons for the end of a cycle, in words for a person: the records hold names of events."""

from opensuction.kernel.name import name_of
from opensuction.procedure.cycle.transition import Event
from opensuction.safety.condition import Condition
from opensuction.session.cycle.cycle_summary import ABORT_SENTENCES

CAUSES = {
    **ABORT_SENTENCES,
    Event.PHASE_OVERDUE: "a phase took longer than planned",
    Event.CHECK_FAILED: "the pre-use test failed",
}
"""Every event that breaks a cycle off, as a report says it; which phase and what failed are not on
record."""
_WORDS = {name_of(one): words for one, words in CAUSES.items()} | {
    name_of(one): one.row.sentence for one in Condition
}


def say(detail: str) -> str:
    """The detail of an outcome in words; what is no list of names stands for itself.

    >>> say("abort-requested")
    'a person asked for it'
    >>> say("tripped, catheter-jammed") == Condition.CATHETER_JAMMED.row.sentence
    True
    >>> say("nobody recorded how it ended")
    'nobody recorded how it ended'
    """
    names = [name for name in detail.split(", ") if name]
    if not names or any(name not in _WORDS for name in names):
        return detail
    # A limit that is named says more than that there was one.
    told = names[1:] if names[0] == name_of(Event.TRIPPED) and len(names) > 1 else names
    return "; ".join(_WORDS[name] for name in told)
