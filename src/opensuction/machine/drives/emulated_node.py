"""Node of CiA 301, emulated: NMT, SDO, emergencies, heartbeats and process data.

The SDO server, the producer of heartbeats and of emergencies are canopen's; process data and the
watch over the host are our own, by SYNC and by the ticks that the node is given. What a node does
with its objects is its profile's: see `emulated_drive` and `emulated_module`.
"""

from pathlib import Path
from typing import Any, Final, cast

from canopen.objectdictionary import ObjectDictionary, ODVariable, import_od
from canopen.objectdictionary.datatypes import INTEGER_TYPES
from canopen.sdo.exceptions import SdoAbortedError

from opensuction.host.host import NS_PER_S, Clock
from opensuction.machine.canopen.frame_bus import CanFrame
from opensuction.machine.canopen.objects import (
    HEARTBEAT_ID,
    NMT_ID,
    SYNC_ID,
    Communication,
    NmtCommand,
    NmtState,
)
from opensuction.machine.canopen.stepped_network import SteppedNetwork
from opensuction.machine.drives import pdo
from opensuction.machine.drives.pdo import Key, Pdo, Values
from opensuction.machine.drives.transceiver import Transceiver

_NS_PER_MS: Final = NS_PER_S // 1000
_TOO_HIGH, _TOO_LOW = 0x06090031, 0x06090032
_ERRORS: Final = 0x1003
"""Predefined error field: the last emergency."""
GENERIC, COMMUNICATION = 0x01, 0x10
"""Bits of the error register."""
HOST_LOST, SHORT_FRAME, INTERNAL = 0x8130, 0x8210, 0x6100
"""Error codes (CiA 301, table 26): heartbeat, length of a PDO, internal software."""


_TOLD: Final = {
    NmtState.BOOTING: "INITIALISING",
    NmtState.STOPPED: "STOPPED",
    NmtState.OPERATIONAL: "OPERATIONAL",
    NmtState.PRE_OPERATIONAL: "PRE-OPERATIONAL",
}
_COMMANDED: Final = {
    NmtCommand.START: NmtState.OPERATIONAL,
    NmtCommand.STOP: NmtState.STOPPED,
    NmtCommand.PREPARE: NmtState.PRE_OPERATIONAL,
}
_ON_LOST_HOST: Final = {0: NmtState.PRE_OPERATIONAL, 2: NmtState.STOPPED}
"""By the object 0x1029; with 1 the state stays."""


class HostWatch:
    """Watch over the host's signs of life: its heartbeats, and SYNC while process data flow.

    It begins with the first sign, and ends where one is missed; then with the next one again.
    """

    def __init__(self) -> None:
        self.patience_ns = 0
        """0: nobody is watched."""
        self._beat_ns: int | None = None
        self._sync_ns: int | None = None

    def beat(self, now_ns: int) -> None:
        """The host has given a heartbeat."""
        self._beat_ns = now_ns

    def sync(self, now_ns: int) -> None:
        """A SYNC has come."""
        self._sync_ns = now_ns

    def end(self) -> None:
        """Watch no more until there is another sign."""
        self._beat_ns = self._sync_ns = None

    def has_lost(self, now_ns: int) -> bool:
        """True once where a sign is missed."""
        if not self.patience_ns:
            return False
        for sign_ns in (self._beat_ns, self._sync_ns):
            if sign_ns is not None and now_ns - sign_ns > self.patience_ns:
                self.end()
                return True
        return False


class EmulatedNode:
    """A node on the bus, with the objects of an EDS file."""

    def __init__(self, number: int, eds: Path, clock: Clock) -> None:
        self.number, self.clock = number, clock
        self.transceiver = Transceiver(number)
        self.network = SteppedNetwork(self.transceiver, clock)
        self.dictionary: ObjectDictionary = import_od(str(eds), number)
        self.local = cast(Any, self.network.create_node(number, self.dictionary))
        self.nmt = NmtState.BOOTING
        self.watch = HostWatch()
        self.values: Values = {}
        """Each object that is a number."""
        self._latched: Values = {}
        self._receives: dict[int, Pdo] = {}
        self._sends: list[Pdo] = []
        self._syncs = 0
        self._host_id: int | None = None
        self._misses_host = False
        self._subscribe()
        self.local.add_read_callback(self._read)
        self.local.add_write_callback(self._write)

    def _subscribe(self) -> None:
        network, local = self.network, self.local
        network.unsubscribe(NMT_ID, local.nmt.on_command)
        network.unsubscribe(local.sdo.rx_cobid, local.sdo.on_request)
        network.subscribe(NMT_ID, self._on_nmt)
        network.subscribe(local.sdo.rx_cobid, self._on_sdo)
        network.subscribe(SYNC_ID, self._on_sync)

    # What a profile fills in.

    def on_boot(self) -> None:
        """All objects have their defaults."""

    def refresh(self) -> None:
        """Set the objects to what was measured last: somebody may ask for them now."""

    def on_set_points(self) -> None:
        """Set points have come, and count now."""

    def on_written(self, key: Key) -> None:
        """An object has been written by SDO."""

    def on_lost_host(self) -> None:
        """The host is lost, or process data do not flow any more."""

    def on_host_back(self) -> None:
        """The host that was lost gives signs of life again."""
        self.end_emergency()

    def fail(self, code: int, bits: int = 0) -> None:
        """Find a fault in itself: it acts as without a host, and says why. bits: as `emergency`."""
        self.on_lost_host()
        self.emergency(code, bits)

    # Network management.

    def boot(self) -> None:
        """Begin anew: all objects as the EDS file has them."""
        self.values = _defaults(self.dictionary)
        self.local.data_store.clear()
        self._latched.clear()
        self.watch, self._misses_host = HostWatch(), False
        self.local.nmt.stop_heartbeat()
        self._read_pdos()
        self._watch_for(0)
        self.on_boot()
        self._enter(NmtState.BOOTING)  # tells that it is there
        self._enter(NmtState.PRE_OPERATIONAL)

    def _enter(self, state: NmtState) -> None:
        self.nmt = state
        self.local.nmt.state = _TOLD[state]

    def _on_nmt(self, _id: int, data: bytearray, _at_s: float) -> None:
        command, number = data[0], data[1]
        if number not in (0, self.number):
            return
        if command in (NmtCommand.RESET, NmtCommand.RESET_COMMUNICATION):
            self.boot()
        elif command in _COMMANDED:
            before = self.nmt
            self._enter(_COMMANDED[NmtCommand(command)])
            if before == NmtState.OPERATIONAL and self.nmt != before:
                self.watch.end()
                self.on_lost_host()

    # Objects by SDO.

    def _on_sdo(self, can_id: int, data: bytearray, at_s: float) -> None:
        if self.nmt != NmtState.STOPPED:
            self.local.sdo.on_request(can_id, data, at_s)

    def _read(self, index: int, subindex: int, **_: Any) -> int | None:
        return self.values.get((index, subindex))

    def _write(self, index: int, subindex: int, od: ODVariable, data: bytes) -> None:
        if od.data_type not in INTEGER_TYPES:
            return
        key, value = (index, subindex), int(od.decode_raw(data))
        if od.max is not None and value > od.max:
            raise SdoAbortedError(_TOO_HIGH)
        if od.min is not None and value < od.min:
            raise SdoAbortedError(_TOO_LOW)
        pdo.check_write(self.values, self.dictionary, key, value)
        self.check_write(key, value)
        self.values[key] = value
        if Communication.RPDO <= index < Communication.TPDO_MAP + 0x200:
            self._read_pdos()
        elif index == Communication.HEARTBEAT_CONSUMER and subindex:
            self._watch_for(value)
        self.on_written(key)

    def check_write(self, key: Key, value: int) -> None:
        """Refuse what an object cannot be set to; raises SdoAbortedError."""

    def _watch_for(self, entry: int) -> None:
        """Watch over a participant, as the object 0x1016 names it."""
        if self._host_id is not None:
            self.network.unsubscribe(self._host_id, self._on_heartbeat)
        number, patience_ms = entry >> 16 & 0x7F, entry & 0xFFFF
        self._host_id = HEARTBEAT_ID + number if number and patience_ms else None
        if self._host_id is not None:
            self.network.subscribe(self._host_id, self._on_heartbeat)
        self.watch.patience_ns = patience_ms * _NS_PER_MS if number else 0
        self.watch.end()

    def _on_heartbeat(self, _id: int, _data: bytearray, _at_s: float) -> None:
        self.watch.beat(self.clock.monotonic_ns())
        if self._misses_host:
            self._misses_host = False
            self.on_host_back()

    # Process data.

    def _read_pdos(self) -> None:
        for can_id in self._receives:
            self.network.unsubscribe(can_id, self._on_rpdo)
        self._receives = {
            one.can_id: one for one in pdo.all_on(self.values, self.dictionary, sends=False)
        }
        for can_id in self._receives:
            self.network.subscribe(can_id, self._on_rpdo)
        self._sends = pdo.all_on(self.values, self.dictionary, sends=True)

    def _on_rpdo(self, can_id: int, data: bytearray, _at_s: float) -> None:
        one = self._receives[can_id]
        if self.nmt != NmtState.OPERATIONAL:
            return
        if len(data) < one.layout.size:
            self.emergency(SHORT_FRAME, COMMUNICATION)
            return
        found = zip(one.keys, one.layout.unpack_from(data), strict=True)
        if one.kind in pdo.AT_ONCE:
            self.values.update(found)
            self.on_set_points()
        else:
            self._latched.update(found)

    def _on_sync(self, _id: int, _data: bytearray, _at_s: float) -> None:
        """Answer with what was measured last, then act on the set points that came before.

        A SYNC that comes twice is answered twice; it has no set points of its own.
        """
        if self.nmt != NmtState.OPERATIONAL:
            return
        self._syncs += 1
        self.watch.sync(self.clock.monotonic_ns())
        self.transceiver.send(
            [
                CanFrame(one.can_id, one.layout.pack(*(self.values[key] for key in one.keys)))
                for one in self._sends
                if self._syncs % one.kind == 0
            ]
        )
        if self._latched:
            self.values.update(self._latched)
            self._latched.clear()
            self.on_set_points()

    # What goes on by time.

    def step(self) -> None:
        """Take what has come, send what is due, and look after the host."""
        if self.transceiver.has_come:
            self.refresh()
        self.network.step()
        if self.watch.has_lost(self.clock.monotonic_ns()):
            self._misses_host = True
            self.on_lost_host()
            self.emergency(HOST_LOST, COMMUNICATION)
            state = _ON_LOST_HOST.get(self.values[Communication.ERROR_BEHAVIOUR, 1])
            if state is not None and self.nmt == NmtState.OPERATIONAL:
                self._enter(state)

    def emergency(self, code: int, bits: int = 0) -> None:
        """Tell of an error. bits: of the error register."""
        self.values[Communication.ERROR_REGISTER, 0] |= bits | GENERIC
        self.values[_ERRORS, 0], self.values[_ERRORS, 1] = 1, code
        if self.nmt not in (NmtState.BOOTING, NmtState.STOPPED):
            self.local.emcy.send(code, self.values[Communication.ERROR_REGISTER, 0])

    def end_emergency(self) -> None:
        """Tell that there is no error any more."""
        self.values[Communication.ERROR_REGISTER, 0] = 0
        self.local.emcy.reset()


def _defaults(dictionary: ObjectDictionary) -> Values:
    """Objects that are numbers, as an EDS file has them."""
    values = {}
    for entry in dictionary.values():
        members = [entry] if isinstance(entry, ODVariable) else list(entry.values())
        for one in members:
            if one.data_type in INTEGER_TYPES:
                values[one.index, one.subindex] = int(one.default or 0)
    return values
