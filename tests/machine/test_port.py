"""Self-description of a machine: what it says is what is read, also of older versions."""

import json

import pytest

from opensuction.kernel.errors import InputError
from opensuction.machine import port
from opensuction.machine.port import EVERYTHING, NOTHING, WORDS, Capabilities, Description
from tests.machine.bare_machine import MACHINE_FACTS


def read(**facts: object) -> Description:
    return port.read_description({port.DESCRIPTION: json.dumps(facts)})


@pytest.mark.parametrize("name", Capabilities._fields)
def test_each_capability_is_read_as_it_was_described(name: str) -> None:
    has = NOTHING._replace(**{name: True})
    told = {port.DESCRIPTION: port.describe(MACHINE_FACTS._replace(capabilities=has))}
    assert port.read_description(told) == Description(in_silico=False, capabilities=has)
    assert WORDS[name] not in has.lacking
    assert len(has.lacking) == len(Capabilities._fields) - 1


def test_the_description_keeps_the_keys_that_it_had_and_names_the_capabilities() -> None:
    told = json.loads(port.describe(MACHINE_FACTS))
    assert list(told) == [
        *("name", "version", "in_silico", "period_s", "watchdog_s", "most", "capabilities"),
    ]
    assert told["capabilities"]["truth"] is False


def test_a_machine_of_an_older_version_is_a_twin_and_has_what_twins_had() -> None:
    assert port.read_description({}) == Description(True, EVERYTHING)
    assert read(name="twin", in_silico=True) == Description(True, EVERYTHING)
    assert EVERYTHING.lacking == ()


def test_what_is_not_claimed_is_not_there() -> None:
    assert read(in_silico=False).capabilities == NOTHING
    assert read(in_silico=True, capabilities={"hand": True}).capabilities == NOTHING
    claimed = {"monitor": True, "truth": "yes", "faults": 1, "of a later version": True}
    assert read(in_silico=True, capabilities=claimed).capabilities == NOTHING._replace(monitor=True)


@pytest.mark.parametrize(
    "text", ["", "{", "[]", "{}", '{"in_silico": true, "capabilities": [1]}'], ids=repr
)
def test_what_describes_nothing_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(InputError, match="does not describe its machine") as refused:
        port.read_description({port.DESCRIPTION: text})
    assert "\n" not in str(refused.value)
