"""canopen's own master and slave over a network that is stepped."""

import canopen
import pytest
from canopen import LocalNode, ObjectDictionary
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import UNSIGNED16, UNSIGNED32
from canopen.sdo.exceptions import SdoCommunicationError

from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.stepped_network import SteppedNetwork
from tests.machine.canopen.stepped_bus import SteppedClock, Wire

NODE = 5
LONG = bytes(range(100))


class Both:
    """A master and a node, which works while the master waits."""

    def __init__(self) -> None:
        self.clock, self.wire = SteppedClock(), Wire()
        self.is_alive = True
        self.slave = SteppedNetwork(self.wire.join(), self.clock)
        self.master = SteppedNetwork(self.wire.join(), self.clock, self.pass_time)
        dictionary = ObjectDictionary()  # type: ignore[no-untyped-call]
        for index, kind in ((0x1017, UNSIGNED16), (0x1018, UNSIGNED32), (0x2000, 0xF)):
            variable = ODVariable("object", index)
            variable.data_type = kind
            variable.default = None if kind == 0xF else 7
            dictionary.add_object(variable)
        self.node: LocalNode = self.slave.create_node(NODE, dictionary)
        self.remote = self.master.add_remote(NODE)

    def pass_time(self) -> None:
        self.clock.now_ns += 1_000_000
        if self.is_alive:
            self.slave.step()


def test_objects_of_any_length_are_read_and_written_without_a_thread() -> None:
    both = Both()
    assert both.remote.sdo.upload(0x1018, 0) == (7).to_bytes(4, "little")
    both.remote.sdo.download(0x2000, 0, LONG)
    assert both.node.get_data(0x2000, 0) == LONG == both.remote.sdo.upload(0x2000, 0)
    with pytest.raises(canopen.SdoAbortedError):
        both.remote.sdo.upload(0x5000, 0)


def test_a_node_that_does_not_answer_is_waited_for_by_the_hosts_clock() -> None:
    both = Both()
    both.is_alive = False
    before_ns = both.clock.now_ns
    with pytest.raises(SdoCommunicationError):
        both.remote.sdo.upload(0x1018, 0)
    assert 0.3e9 <= both.clock.now_ns - before_ns <= 0.31e9
    both.is_alive = True
    both.pass_time()  # its answer comes after all, and is not taken for the next one's
    both.master.step()
    assert both.remote.sdo.upload(0x1017, 0) == (7).to_bytes(2, "little")
    assert both.remote.sdo.upload(0x1018, 0) == (7).to_bytes(4, "little")


def test_heartbeats_come_by_the_steps() -> None:
    both = Both()
    both.node.nmt.state = "INITIALISING"
    both.node.nmt.state = "PRE-OPERATIONAL"  # begins to send, by object 0x1017
    for _ in range(70):
        both.pass_time()
    beats = [one for one in both.wire.sent if one.can_id == 0x700 + NODE]
    assert [one.data for one in beats] == [b"\0", *[b"\x7f"] * 11]
    both.master.step()
    assert both.remote.nmt.state == "PRE-OPERATIONAL"


def test_nonsense_is_counted_and_ends_nothing() -> None:
    both = Both()
    third = both.wire.join()
    third.send([CanFrame(0, b"\1"), CanFrame(0x80 + NODE, b"\1"), CanFrame(0x700 + NODE, b"")])
    third.send([CanFrame(0x600 + NODE, b"")])
    assert both.master.step() == 4
    assert both.master.nonsense >= 2
    assert both.remote.sdo.upload(0x1018, 0) == (7).to_bytes(4, "little")
