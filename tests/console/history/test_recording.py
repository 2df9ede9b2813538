"""Recordings over the interface: given whole or in part, reported, and no others."""

import json
import os
import re
from collections.abc import Callable
from pathlib import Path

import pytest

from opensuction.console.history import job_queue
from opensuction.console.route import history
from opensuction.recording.cycle_file import frame
from opensuction.recording.cycle_file.reader import RecordingReader, Rows
from opensuction.recording.cycle_file.row_schema import TABLES
from opensuction.recording.cycle_file.writer import RecordingWriter
from opensuction.records import recording_check
from opensuction.records.entry import BoundFile, CycleEnd, Outcome
from tests.console.history.past import (
    ATTACK,
    NOON,
    RECORDING,
    Past,
    join,
    remember,
    start,
    work_here,
)
from tests.console.served import Served
from tests.runtime.identity import ABOUT

V1 = "/api/v1"


def test_a_recording_is_given_whole_and_in_parts(console: Served, recording: Path) -> None:
    past = remember(console, recording)
    client, path = console.client("observer"), f"{V1}/cycles/{past.completed}/recording"
    data = recording.read_bytes()
    answer = client.get(path)
    assert (answer.status_code, answer.content == data) == (200, True)
    assert answer.headers["content-disposition"] == 'attachment; filename="cycle-1.mcap"'
    assert answer.headers["content-type"] == "application/octet-stream"
    for asked, expected in (
        ("bytes=0-99", data[:100]),
        ("bytes=1000-", data[1000:]),
        ("bytes=-64", data[-64:]),
        (f"bytes=5-{len(data) + 5}", data[5:]),
    ):
        answer = client.get(path, headers={"Range": asked})
        assert (answer.status_code, answer.content == expected) == (206, True), asked
    assert client.get(f"{path}?part=2").status_code == 404
    acts = console.site.records.history.list_actions(cycle_id=past.completed)
    taken = [(one.done_by, one.detail) for one in acts if one.what == "take-recording"]
    assert taken == [("cora", "cycle 1")], "once, not for each piece of it"
    assert console.client("engineer").get(path).status_code == 200
    acts = console.site.records.history.list_actions(cycle_id=past.completed)
    assert [one.done_by for one in acts if one.what == "take-recording"] == ["bert", "cora"]
    assert console.client().get(path).status_code == 401


HUGE = "9" * 5_000
"""Digits: more than Python takes for a number."""


@pytest.mark.parametrize(
    "asked",
    [
        "bytes=9-1",
        f"bytes={HUGE}-1",
        "bytes=",
        "bytes=-",
        "bytes=,",
        "bytes=0-1,3-4",
        "bytes=0x0-5",
        "bytes=+1-5",
        "bytes=1-5-9",
        "bytes 0-5",
        "lines=0-1",
        "x",
        "",
        "bytes=\u0661-\u0665".encode(),
        b"bytes=\xb2-\xff",
    ],
)
def test_a_range_that_is_none_is_ignored(
    console: Served, recording: Path, asked: str | bytes
) -> None:
    past = remember(console, recording)
    client, path = console.client("observer"), f"{V1}/cycles/{past.completed}/recording"
    answer = client.get(path, headers={"Range": asked})
    assert (answer.status_code, answer.content == recording.read_bytes()) == (200, True)
    acts = console.site.records.history.list_actions(cycle_id=past.completed)
    assert any(one.what == "take-recording" for one in acts), "the whole of it was taken"
    page = client.get("/icon.svg", headers={"Range": asked})
    assert (page.status_code, page.headers["content-type"]) == (200, "image/svg+xml")


def test_only_a_range_of_which_a_file_has_nothing_is_refused(
    console: Served, recording: Path
) -> None:
    past = remember(console, recording)
    client, path = console.client("observer"), f"{V1}/cycles/{past.completed}/recording"
    data = recording.read_bytes()
    for asked in (f"bytes={len(data)}-", "bytes=-0", f"bytes={HUGE}-", f"bytes={HUGE}-{HUGE}9"):
        for file, size in ((path, len(data)), ("/icon.svg", None)):
            answer = client.get(file, headers={"Range": asked})
            assert answer.status_code == 416, (file, asked[:40])
            assert answer.headers["content-type"] == "application/problem+json"
            assert answer.json()["detail"].startswith("the file has no byte of the range")
            if size is not None:
                assert answer.headers["content-range"] == f"bytes */{size}"
    acts = console.site.records.history.list_actions(cycle_id=past.completed)
    assert not any(one.what == "take-recording" for one in acts), "nothing of it was given"
    for asked, expected in (
        (f"bytes=5-{HUGE}", data[5:]),
        ("Bytes=0000000000000000000000-9 ,", data[:10]),
        (f"bytes=-{HUGE}", data),
    ):
        answer = client.get(path, headers={"Range": asked})
        assert (answer.status_code, answer.content == expected) == (206, True), asked[:40]
    taken = console.site.records.history.list_actions(cycle_id=past.completed)
    assert any(one.what == "take-recording" for one in taken), "from the first byte on"


def test_only_finished_recordings_of_this_folder_are_given(
    console: Served, recording: Path, tmp_path: Path
) -> None:
    past = remember(console, recording)
    client = console.client("engineer")
    assert client.get(f"{V1}/cycles/{past.running}/recording").status_code == 409
    assert client.get(f"{V1}/cycles/{past.lost}/recording").status_code == 404
    secret = tmp_path / "secret.mcap"
    secret.write_text("secret")
    (console.site.recordings / "linked.mcap").symlink_to(secret)
    os.mkfifo(console.site.recordings / "pipe.mcap")
    names = ("linked.mcap", "pipe.mcap", str(secret), "../secret.mcap", "a/../../b.mcap", "..mcap")
    records = console.site.records
    records.end_cycle(past.running, CycleEnd(Outcome.INTERRUPTED))
    for name in names:
        cycle = records.begin_cycle(start(name), at=NOON)
        records.end_cycle(cycle, CycleEnd(Outcome.COMPLETED), at=NOON)
        for path in ("recording", "report", "replay"):
            assert client.get(f"{V1}/cycles/{cycle}/{path}").status_code == 404, name
        assert client.get(f"{V1}/cycles/{cycle}").json()["has_recording"] is False


def test_parts_that_recorders_left_belong_together(tmp_path: Path) -> None:
    for name in ("a.mcap", "a-2.mcap", "a-3.mcap", "a-5.mcap", "b.mcap"):
        (tmp_path / name).write_bytes(b"x" * 10)
    found = job_queue.find(tmp_path, "a.mcap")
    assert found is not None
    assert [part.name for part in found.parts] == ["a.mcap", "a-2.mcap", "a-3.mcap"]
    assert found.size == 30
    for other in (None, "", ".mcap", "A" * 200 + ".mcap", "a.mcap\n", "a.txt", "a\0.mcap"):
        assert job_queue.find(tmp_path, other) is None


def test_a_report_may_run_its_own_scripts_and_nothing_else(
    console: Served, recording: Path
) -> None:
    past = remember(console, recording)
    path = f"{V1}/cycles/{past.completed}/report"
    answer = console.client("observer").get(path)
    assert answer.status_code == 200
    assert answer.headers["content-type"].startswith("text/html")
    policy = answer.headers["content-security-policy"]
    assert policy == history.policy()
    assert "sandbox allow-scripts" in policy
    assert "default-src 'none'" in policy
    scripts = re.findall(r"script-src ([^;]*)", policy)[0]
    assert "unsafe" not in scripts
    assert "'self'" not in scripts
    assert "By the controller" in answer.text or "by the controller" in answer.text
    again = console.client("observer").get(path)
    assert again.content == answer.content
    assert console.client().get(path).status_code == 401


@pytest.mark.usefixtures("here")
def test_a_report_of_what_is_no_recording_is_refused_in_one_line(console: Served) -> None:
    past = remember(console, None)
    (console.site.recordings / RECORDING).write_bytes(b"no recording\n" * 10)
    answer = console.client("observer").get(f"{V1}/cycles/{past.completed}/report")
    assert answer.status_code == 422
    detail = answer.json()["detail"]
    assert detail.startswith(f"{RECORDING}: is no MCAP file")
    assert str(console.site.recordings) not in detail


def test_figures_are_worked_out_once_and_kept_beside_the_recordings(
    console: Served, recording: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    past = remember(console, recording)
    client = console.client("observer")
    begun = client.get(f"{V1}/trends").json()
    assert (begun["pending"], begun["without_recording"]) == (1, 2)
    join("_fill")
    found = client.get(f"{V1}/trends").json()
    assert found["pending"] == 0
    quantities = found["days"][0]["quantities"]
    assert quantities["vacuum_mmhg"]["cycles"] == 1
    assert quantities["vacuum_mmhg"]["median"] > 50.0
    assert quantities["removed_ml"] is None, "no machine measures it"
    (kept,) = (console.site.recordings / ".history").glob("*.figure.json")
    assert json.loads(kept.read_text())["gap_mm"] == quantities["gap_mm"]["median"]
    recorded = console.site.recordings / RECORDING
    recorded.write_bytes(b"no recording")
    work_here(monkeypatch)  # one process has shown that it does it
    client.get(f"{V1}/trends")
    join("_fill")
    found = client.get(f"{V1}/trends").json()
    assert found["without_recording"] == 3
    assert found["days"][0]["quantities"]["vacuum_mmhg"] is None, "nothing old is shown"
    assert past.completed


@pytest.mark.usefixtures("here")
def test_names_and_details_stay_text(console: Served, recording: Path) -> None:
    reader = RecordingReader(recording)
    about = {**reader.heading.about, "patient": ATTACK, "machine": ATTACK}
    rows = [one for one in reader.contents() if isinstance(one, Rows)]
    path = console.site.recordings.parent / "attack.mcap"
    with RecordingWriter(path, reader.heading._replace(about=about), TABLES) as file:
        for one in rows:
            file.add_rows(one.topic, one.times_ns, one.table)
    past = remember(console, path)
    answer = console.client("observer").get(f"{V1}/cycles/{past.completed}/report")
    assert answer.status_code == 200
    assert "<img" not in answer.text


OTHER = "20261124T120000-0badcafe-000001250.mcap"


def remember_bound(console: Served, recording: Path) -> tuple[Past, str]:
    """The same past with its recording on record, and a cycle that was aborted with its own."""
    past = remember(console, recording)
    records, folder = console.site.records, console.site.recordings
    reader = RecordingReader(recording)
    rows = [one for one in reader.contents() if isinstance(one, Rows)]
    with RecordingWriter(folder / OTHER, reader.heading, TABLES) as file:
        for one in rows[: len(rows) // 2]:
            file.add_rows(one.topic, one.times_ns, one.table)
    records.end_cycle(past.running, CycleEnd(Outcome.INTERRUPTED))
    aborted = records.begin_cycle(start(OTHER), at=NOON)
    records.end_cycle(aborted, CycleEnd(Outcome.ABORTED), at=NOON)
    for name in (RECORDING, OTHER):
        (found,) = frame.measure(folder / name)
        file_of = BoundFile(name, name, 1, str(folder), *found, is_closed=True)
        records.bind_recording(ABOUT.machine, file_of)
    return past, aborted


@pytest.mark.usefixtures("here")
def test_no_report_is_made_of_another_cycle_s_recording(console: Served, recording: Path) -> None:
    past, aborted = remember_bound(console, recording)
    client, folder = console.client("engineer"), console.site.recordings
    assert client.get(f"{V1}/cycles/{aborted}/report").status_code == 200
    assert client.get(f"{V1}/cycles/{past.completed}/report").status_code == 200
    one = client.get(f"{V1}/cycles/{past.completed}").json()
    assert (one["recording_bound"], one["recording_fault"]) == (True, None)
    (folder / RECORDING).rename(folder / "aside")
    (folder / OTHER).rename(folder / RECORDING)
    (folder / "aside").rename(folder / OTHER)
    words = (
        f"the recording {OTHER} of cycle 4 of machine twin-1 was swapped: the file there is the "
        f"recording {RECORDING} of cycle 1 of machine twin-1"
    )
    for path in ("report", "recording", "replay"):
        answer = client.get(f"{V1}/cycles/{aborted}/{path}")
        assert (answer.status_code, answer.json()["detail"]) == (422, words), path
        assert answer.headers["content-type"] == "application/problem+json"
    assert client.get(f"{V1}/cycles/{aborted}").json()["recording_fault"] == words
    listed = {one["id"]: one for one in client.get(f"{V1}/cycles").json()["cycles"]}
    assert "has another length" in listed[aborted]["recording_fault"]
    client.get(f"{V1}/trends")
    join("_fill")
    trends = client.get(f"{V1}/trends").json()
    assert (trends["pending"], trends["without_recording"]) == (0, trends["cycles"])
    client.post(f"{V1}/audit", json={})
    join("_read_trail")
    verdict = client.get(f"{V1}/audit").json()["verdict"]
    assert (verdict["is_whole"], len(verdict["faults"])) == (False, 2)


def cut(path: Path) -> None:
    path.write_bytes(path.read_bytes()[:-1])


def change(path: Path) -> None:
    """One bit, and the file's time is what it was."""
    facts, data = path.stat(), bytearray(path.read_bytes())
    data[len(data) // 2] ^= 1
    path.write_bytes(data)
    os.utime(path, ns=(facts.st_atime_ns, facts.st_mtime_ns))


def add_part(path: Path) -> None:
    part = path.with_name(f"{path.stem}-2.mcap")
    part.write_bytes(path.read_bytes())


@pytest.mark.parametrize(
    ("hand", "status", "words"),
    [
        (cut, 422, "was cut: "),
        (change, 422, "was changed: "),
        (Path.unlink, 404, "is missing"),
        (add_part, 422, f"{RECORDING[:-5]}-2.mcap lies beside the recording {RECORDING} of cycle"),
    ],
    ids=["cut", "changed", "removed", "a part added"],
)
def test_a_recording_that_is_not_as_it_was_is_said_in_words(
    console: Served,
    recording: Path,
    monkeypatch: pytest.MonkeyPatch,
    hand: Callable[[Path], None],
    status: int,
    words: str,
) -> None:
    monkeypatch.setattr(recording_check, "RECENT_S", -1.0)
    past, _ = remember_bound(console, recording)
    client = console.client("observer")
    assert client.get(f"{V1}/cycles/{past.completed}/replay").status_code == 200
    hand(console.site.recordings / RECORDING)
    answer = client.get(f"{V1}/cycles/{past.completed}/report")
    assert answer.status_code == status
    assert words in answer.json()["detail"]
    assert str(console.site.recordings) not in answer.json()["detail"]
    assert words in client.get(f"{V1}/cycles/{past.completed}").json()["recording_fault"]


@pytest.mark.usefixtures("here")
def test_one_without_a_hash_on_record_is_unbound_and_shown(
    console: Served, recording: Path
) -> None:
    past = remember(console, recording)
    client = console.client("observer")
    one = client.get(f"{V1}/cycles/{past.completed}").json()
    assert (one["recording_bound"], one["recording_fault"]) == (False, None)
    assert client.get(f"{V1}/cycles/{past.completed}/report").status_code == 200
    reader = RecordingReader(recording)
    about = {**reader.heading.about, "file": OTHER}
    path = console.site.recordings / RECORDING
    path.unlink()
    rows = [one for one in reader.contents() if isinstance(one, Rows)]
    with RecordingWriter(path, reader.heading._replace(about=about), TABLES) as file:
        file.add_rows(rows[0].topic, rows[0].times_ns, rows[0].table)
    detail = client.get(f"{V1}/cycles/{past.completed}/report").json()["detail"]
    assert detail.startswith(f"{RECORDING} is not what it is called")
    assert OTHER in detail, "it says so itself"
