"""``opensuction replay``, ``report`` and ``export``, on what ``opensuction cycle`` leaves."""

import csv
import json
import shutil
import sys
from pathlib import Path

import pyarrow.parquet
import pytest

from opensuction.kernel import arithmetic_fingerprint
from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.records.entry import BoundFile
from opensuction.records.records import Records
from tests.cli.command import Ran, largest_file, opensuction, opensuction_process
from tests.kernel.another_arithmetic import ANOTHER_WAY, takes_another_way
from tests.records.example import COMPLETED, MACHINE, start

CYCLE = ("cycle", "--machine", "bench", "--compensation", "none", "--seed", "5")
HEAD = "inputs.readings.head_mm"


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run in it."""
    made = tmp_path_factory.mktemp("run")
    ran = opensuction(*CYCLE, "--json", "--out", "run", cwd=made)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["recording"] == "recording.mcap"
    assert data["arithmetic_fingerprint"] == arithmetic_fingerprint.fingerprint()
    return made


@pytest.fixture
def recording(folder: Path, tmp_path: Path) -> Path:
    """A copy of its recording."""
    return Path(shutil.copy(folder / "run" / "recording.mcap", tmp_path / "a.mcap"))


def one_line(ran: Ran, status: int) -> str:
    """The only line of what a command says on stderr."""
    assert ran.returncode == status, ran.stderr
    (line,) = ran.stderr.strip().splitlines()
    return line


def test_replay_says_identical_and_of_what(folder: Path) -> None:
    ran = opensuction("replay", "run/recording.mcap", cwd=folder)
    assert (ran.returncode, ran.stderr) == (0, "")
    first, second = ran.stdout.splitlines()
    assert first.startswith("Identical: every output and state of ")
    assert "machine bench" in second
    assert "seed 5" in second


def test_the_json_of_replay_has_the_promised_keys(folder: Path) -> None:
    data = json.loads(opensuction("replay", "run/recording.mcap", "--json", cwd=folder).stdout)
    assert (data["identical"], data["equivalent"], data["first_difference"]) == (True, True, None)
    assert (data["whole"], data["damaged"], data["flaw"], data["notes"]) == (True, False, None, [])
    assert (data["gaps"], data["starts"]) == (0, 1)
    assert data["ticks"] > 25_000
    assert data["recorded"]["seed"] == "5"
    assert data["recorded"]["fingerprint"] == data["here"]["fingerprint"]


def test_several_recordings_have_a_line_each_and_an_entry_each(
    folder: Path, recording: Path
) -> None:
    whole = str(folder / "run" / "recording.mcap")
    recording.write_bytes(recording.read_bytes()[:1_000_000])
    (recording.parent / "empty.mcap").touch()
    names = (whole, "empty.mcap", "a.mcap")
    ran = opensuction("replay", *names, cwd=recording.parent)
    first, second, third = ran.stdout.splitlines()
    assert first.startswith(f"{whole}: Identical: every output and state of ")
    assert second.startswith("empty.mcap: is empty")
    assert third.startswith("a.mcap: Identical: ")
    assert ran.returncode == 2, "one of them could not be replayed"
    assert "a.mcap: was not finished" in ran.stderr

    told = opensuction("replay", *names, "--json", cwd=recording.parent)
    found = json.loads(told.stdout)["recordings"]
    assert [one["file"] for one in found] == list(names)
    assert "is empty" in found[1]["refused"]
    alone = json.loads(opensuction("replay", whole, "--json", cwd=folder).stdout)
    assert found[0] == alone, "one recording keeps the object that it had"
    assert opensuction("replay", whole, whole, cwd=folder).returncode == 0


def test_one_of_several_that_is_damaged_is_told_by_the_status(
    folder: Path, recording: Path
) -> None:
    content = bytearray(recording.read_bytes())
    content[len(content) // 2] ^= 0x10
    recording.write_bytes(content)
    whole = str(folder / "run" / "recording.mcap")
    ran = opensuction("replay", "a.mcap", whole, cwd=recording.parent)
    assert ran.returncode == 1, ran.stderr
    assert len(ran.stdout.splitlines()) == 2


def test_another_arithmetic_and_another_version_are_said(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(arithmetic_fingerprint, "fingerprint", lambda: "0123456789abcdef")
    monkeypatch.setattr("opensuction.session.recorded.replay_run.__version__", "9.9.9")
    ran = opensuction("replay", "run/recording.mcap", cwd=folder)
    assert ran.returncode == 0
    assert "its arithmetic was another" in ran.stdout
    assert "here 0123456789abcdef" in ran.stdout
    assert "this is 9.9.9" in ran.stdout


@pytest.mark.sweep
@pytest.mark.skipif(
    not takes_another_way(), reason="needs glibc and a processor that has AVX2 and FMA"
)
def test_a_library_that_takes_another_way_gives_what_is_equivalent(folder: Path) -> None:
    arguments = ("replay", "run/recording.mcap", "--json")
    done = opensuction_process(*arguments, cwd=folder, environment=ANOTHER_WAY)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["equivalent"] is True
    assert data["recorded"]["fingerprint"] != data["here"]["fingerprint"]
    assert "its arithmetic was another" in data["notes"][0]


def test_names_in_a_recording_cannot_speak_to_the_terminal(recording: Path) -> None:
    reader = RecordingReader(recording)
    told = reader.heading._replace(
        software_version="\x1b[2J9", about={"patient": "\x1b]0;x\x07", "notice": "\r"}
    )
    rows = [one for one in reader.contents() if isinstance(one, Rows)]
    with RecordingWriter(recording.with_name("b.mcap"), told, reader.tables) as file:
        for one in rows[:8]:
            file.add_rows(one.topic, one.times_ns, one.table)
    ran = opensuction("replay", "b.mcap", cwd=recording.parent)
    assert ran.returncode == 0
    assert "\\x1b[2J9" in ran.stdout
    assert "\x1b" not in ran.stdout + ran.stderr


def test_one_that_was_cut_off_is_replayed_to_there(recording: Path) -> None:
    recording.write_bytes(recording.read_bytes()[:1_000_000])
    ran = opensuction("replay", recording.name, "--json", cwd=recording.parent)
    line = one_line(ran, 0)
    assert "a.mcap: was not finished: it ends at byte 1000000" in line
    assert "could be read" in line
    data = json.loads(ran.stdout)
    assert (data["identical"], data["whole"], data["damaged"]) == (True, False, False)
    assert data["flaw"] == line


def test_a_damaged_one_is_told_and_does_not_pass(recording: Path) -> None:
    content = bytearray(recording.read_bytes())
    content[1_000_000] ^= 0x10
    recording.write_bytes(content)
    for command in (("replay",), ("export", "--columns", HEAD), ("report",)):
        ran = opensuction(*command, recording.name, "--json", cwd=recording.parent)
        assert ran.returncode == 1
        *progress, last = ran.stderr.strip().splitlines()
        assert "a.mcap: is damaged at byte" in last
        # A slow computer tells how far it is, and nothing else.
        assert all(line.startswith(("Exporting: ", "Compil")) for line in progress), progress
        assert json.loads(ran.stdout)["damaged"] is True


@pytest.mark.parametrize("command", ["replay", "export", "report"])
def test_what_is_no_recording_is_refused(tmp_path: Path, command: str) -> None:
    (tmp_path / "empty.mcap").touch()
    (tmp_path / "table.csv").write_text("time_s,head_mm\n0,1\n")
    for name, words in (
        ("empty.mcap", "is empty"),
        ("table.csv", "is no MCAP file"),
        ("gone.mcap", "no such file"),
        (".", "is a folder"),
    ):
        ran = opensuction(command, name, "--json", cwd=tmp_path)
        assert ran.stdout == ""
        assert words in one_line(ran, 2)
    assert len(list(tmp_path.iterdir())) == 2


def test_the_report_of_a_recording_is_written(folder: Path, tmp_path: Path) -> None:
    file = str(folder / "run" / "recording.mcap")
    ran = opensuction("report", file, "--out", "page", cwd=tmp_path)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert "By the controller's estimate the tip went" in " ".join(ran.stdout.split())
    data = json.loads((tmp_path / "page" / "report.json").read_text())
    cycle = json.loads((folder / "run" / "cycle.json").read_text())
    assert data["basis"] == "recorded"
    for same in ("outcome", "machine", "protocol", "seed"):
        assert str(data[same]) == str(cycle[same])
    assert data["phases"] == cycle["phases"]
    assert "by the controller" in (tmp_path / "page" / "report.html").read_text()


def test_one_that_was_cut_off_is_reported_to_there(recording: Path) -> None:
    recording.write_bytes(recording.read_bytes()[:1_000_000])
    ran = opensuction("report", recording.name, "--json", "--out", "page", cwd=recording.parent)
    line = one_line(ran, 0)
    assert "a.mcap: was not finished: it ends at byte 1000000" in line
    data = json.loads(ran.stdout)
    assert (data["outcome"], data["flaw"]) == ("interrupted", line)


def test_no_heading_reaches_the_terminal_by_a_report(recording: Path) -> None:
    reader = RecordingReader(recording)
    told = reader.heading._replace(
        software_version="\x1b[2J9",
        about={"machine": "\x1b[31mx", "patient": "\x1b]0;x\x07", "notice": "\r"},
    )
    rows = [one for one in reader.contents() if isinstance(one, Rows)]
    with RecordingWriter(recording.with_name("b.mcap"), told, reader.tables) as file:
        for one in rows:
            file.add_rows(one.topic, one.times_ns, one.table)
    ran = opensuction("report", "b.mcap", cwd=recording.parent)
    assert ran.returncode == 0, ran.stderr
    assert "\x1b" not in ran.stdout + ran.stderr


def columns(path: Path) -> dict[str, tuple[str, ...]]:
    """A table by its columns."""
    with path.open(newline="") as file:
        names, *rows = csv.reader(file)
    return dict(zip(names, zip(*rows, strict=True), strict=True))


def test_chosen_columns_come_as_csv_with_their_time(folder: Path, tmp_path: Path) -> None:
    wanted = ("--columns", HEAD, "--columns", "outputs.phase", "--columns", "truth.tip_*")
    file, out = str(folder / "run" / "recording.mcap"), str(tmp_path / "out")
    ran = opensuction("export", file, *wanted, "--json", "--out", out, cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data == json.loads((tmp_path / "out" / "recording.json").read_text())
    ticks = columns(tmp_path / "out" / "tick.csv")
    assert list(ticks) == ["time_s", HEAD, "outputs.phase"]
    assert ticks["time_s"][:3] == ("0.0", "0.001", "0.002")
    assert data["tables"][0]["rows"] == len(ticks[HEAD])
    assert set("".join(ticks["outputs.phase"])) <= set("0123456789")
    twin = columns(tmp_path / "out" / "twin.csv")
    assert list(twin) == ["time_s", "truth.tip_mm", "truth.tip_vacuum_mmhg"]
    assert twin["time_s"][1] == "0.01"
    told = columns(tmp_path / "out" / "event.csv")
    assert "inserting" in told["name"]
    assert data["events"]["rows"] == len(told["name"])


def test_parquet_holds_the_same_numbers_and_their_kinds(folder: Path, tmp_path: Path) -> None:
    file = str(folder / "run" / "recording.mcap")
    of_each_kind = ("inputs.tick", "inputs.readings.head_*", "inputs.requests.s*")
    chosen = [word for name in of_each_kind for word in ("--columns", name)]
    for form in ("csv", "parquet"):
        arguments = ("--format", form, "--out", form)
        assert opensuction("export", file, *chosen, *arguments, cwd=tmp_path).returncode == 0
    table = pyarrow.parquet.read_table(tmp_path / "parquet" / "tick.parquet")
    kinds = {field.name: str(field.type) for field in table.schema}
    assert kinds["inputs.tick"] == "int64"
    assert kinds["inputs.readings.head_valid"] == "bool"
    assert kinds[HEAD] == "double"
    text = columns(tmp_path / "csv" / "tick.csv")
    assert table.column(HEAD).to_pylist() == [float(cell) for cell in text[HEAD]]
    flags = [str(int(one)) for one in table.column("inputs.requests.start").to_pylist()]
    assert tuple(flags) == text["inputs.requests.start"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--format", "xlsx"), "--format xlsx: should be csv or parquet"),
        (("--columns", "inputs.readings.hed_mm"), f"did you mean '{HEAD}'"),
        (("--columns", "none.*"), "unknown column 'none.*'"),
    ],
)
def test_what_cannot_be_meant_is_refused(
    recording: Path, arguments: tuple[str, ...], words: str
) -> None:
    ran = opensuction("export", recording.name, *arguments, cwd=recording.parent)
    assert words in one_line(ran, 2)
    assert [file.name for file in recording.parent.iterdir()] == ["a.mcap"]


def test_without_pyarrow_parquet_is_refused_with_the_remedy(
    recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    ran = opensuction("export", recording.name, "--format", "parquet", cwd=recording.parent)
    assert "pip install 'opensuction[parquet]'" in one_line(ran, 2)


@pytest.mark.skipif(sys.platform == "win32", reason="no limit of a file's size")
def test_a_full_disk_leaves_nothing_half_written(recording: Path) -> None:
    with largest_file(1_000_000):
        ran = opensuction("export", "a.mcap", "--out", "out", cwd=recording.parent)
    assert one_line(ran, 74).startswith("opensuction: tick.csv: file too large")
    assert ran.stdout == ""
    assert [file.name for file in recording.parent.iterdir()] == ["a.mcap"]


def test_a_cycle_can_leave_no_recording_and_none_of_an_older_run(tmp_path: Path) -> None:
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "recording.mcap").write_bytes(b"of an older run")
    arguments = ("--no-recording", "--json", "--out", "run", "--force")
    ran = opensuction(*CYCLE, *arguments, cwd=tmp_path)
    assert json.loads(ran.stdout)["recording"] is None
    assert not (tmp_path / "run" / "recording.mcap").exists()


NAME, OTHER = (f"20261123T120000-0badcafe-00000{tick}.mcap" for tick in (1250, 9250))


@pytest.fixture
def bound(recording: Path) -> Path:
    """The same under a recorder's name, on record in ward.db as that of cycle 1."""
    path = recording.rename(recording.with_name(NAME))
    with Records.open(str(path.with_name("ward.db"))) as records:
        for name in (NAME, OTHER):
            cycle = records.begin_cycle(start()._replace(recording=name))
            records.end_cycle(cycle, COMPLETED)
        (found,) = frame.measure(path)
        file = BoundFile(NAME, NAME, 1, str(path.parent), *found, is_closed=True)
        records.bind_recording(MACHINE, file)
        digest = "0f" * 32
        other = file._replace(name=OTHER, cycle_recording=OTHER, sha256=digest)
        records.bind_recording(MACHINE, other)
    return path


def report(folder: Path, name: str) -> Ran:
    return opensuction(
        "report", name, "--database", "ward.db", "--out", "page", "--json", cwd=folder
    )


def test_a_report_says_that_its_file_is_what_was_put_on_record(bound: Path) -> None:
    ran = report(bound.parent, NAME)
    assert (ran.returncode, ran.stderr) == (0, "")
    assert json.loads(ran.stdout)["on_record"] == {
        "state": "bound",
        "sentence": f"the recording {NAME} of cycle 1 of machine M-1, as its recorder left it",
    }
    page = (bound.parent / "page" / "report.html").read_text()
    assert f"the recording {NAME} of cycle 1 of machine M-1" in page


def test_under_any_other_name_it_is_known_by_what_it_holds(bound: Path) -> None:
    shutil.copy(bound, bound.with_name("cycle-1.mcap"))
    assert json.loads(report(bound.parent, "cycle-1.mcap").stdout)["on_record"]["state"] == "bound"


@pytest.mark.parametrize("is_on_record", [True, False])
def test_no_report_is_made_of_another_cycle_s_file_under_this_one_s_name(
    bound: Path, is_on_record: bool
) -> None:
    name = OTHER if is_on_record else OTHER.replace("9250", "7250")
    bound.rename(bound.with_name(name))
    line = one_line(report(bound.parent, name), 2)
    assert f"the recording {NAME} of cycle 1 of machine M-1" in line
    assert name in line
    assert not (bound.parent / "page").exists()


def test_one_that_was_cut_is_reported_and_said_to_be_so(bound: Path) -> None:
    bound.write_bytes(bound.read_bytes()[:-100])
    ran = report(bound.parent, NAME)
    assert ran.returncode == 1
    assert f"the recording {NAME} of cycle 1 of machine M-1 was cut: " in ran.stderr
    data = json.loads(ran.stdout)
    assert data["on_record"]["state"] == "cut"
    assert "was cut: " in (bound.parent / "page" / "report.html").read_text()


def test_one_that_nothing_is_on_record_of_is_unbound(bound: Path, folder: Path) -> None:
    shutil.copy(bound, bound.with_name("a.mcap"))
    Path(bound.with_name("a.mcap")).write_bytes(bound.read_bytes()[:-1])
    assert json.loads(report(bound.parent, "a.mcap").stdout)["on_record"] == {
        "state": "unbound",
        "sentence": "unbound: no hash of it is on record",
    }
    line = one_line(
        opensuction("report", "run/recording.mcap", "--database", "x.db", cwd=folder), 2
    )
    assert "no such file" in line
