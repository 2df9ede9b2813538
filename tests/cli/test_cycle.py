"""The ``cycle`` command as its users meet it."""

import json
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from opensuction.procedure.cycle.check import ORDER
from opensuction.procedure.planning.protocol import PAPER
from tests.cli.command import Ran, opensuction, unrecorded

PAPER_CYCLE = ("cycle", "--protocol", "paper")

KEYS = {
    "outcome",
    "protocol",
    "approach",
    "seed",
    "phases",
    "tip",
    "timing",
    "vacuum",
    "carina_force_peak_n",
    "secretion",
    "preoxygenation",
    "spo2_nadir_percent",
    "lung_volume_loss_ml",
    "trips",
    "alarms",
    "wall_s",
    "realtime_factor",
}
"""Keys that scripts rely on."""


def protocol_file(folder: Path, **changes: object) -> Path:
    values = {**PAPER._asdict(), **changes}
    lines = [
        f"{key} = {json.dumps(value) if not isinstance(value, str) else value}"
        for key, value in values.items()
        if value is not None
    ]
    file = folder / "protocol.toml"
    file.write_text("\n".join(lines) + "\n")
    return file


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], Path, str]:
    folder = tmp_path_factory.mktemp("cycle")
    ran = opensuction(*PAPER_CYCLE, "--json", "--out", "run", "--seed", "3", cwd=folder)
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout), folder / "run", ran.stderr


def test_json_is_one_object_with_the_promised_keys(
    finished: tuple[dict[str, Any], Path, str],
) -> None:
    data, _, progress = finished
    assert data.keys() >= KEYS
    assert data["tip"].keys() >= {
        "target_mm",
        "reached_mm",
        "stop_error_mm",
        "rmse_mm",
        "peak_error_mm",
    }
    assert data["outcome"] == "completed"
    assert data["seed"] == 3
    # Progress belongs on stderr.
    assert progress.startswith("One suction cycle on the digital twin: machine bench, protocol ")
    assert "protocol paper, approach travel, " in progress
    assert "Identifying" in progress


def test_files_hold_the_same_figures_as_stdout(
    finished: tuple[dict[str, Any], Path, str],
) -> None:
    data, folder, _ = finished
    assert sorted(file.name for file in folder.iterdir()) == [
        "cycle.json",
        "recording.mcap",
        "report.html",
    ]
    assert json.loads((folder / "cycle.json").read_text()) == data


def test_phases_follow_one_another_without_a_gap(
    finished: tuple[dict[str, Any], Path, str],
) -> None:
    phases = finished[0]["phases"]
    assert [phase["name"] for phase in phases] == [
        "checking",
        "preloading",
        "inserting",
        "opening",
        "suctioning",
        "withdrawing",
        "closing",
        "parked",
    ]
    for earlier, later in pairwise(phases):
        assert earlier["end_s"] == later["start_s"]


@pytest.fixture(scope="module")
def shown(tmp_path_factory: pytest.TempPathFactory) -> tuple[Ran, Path]:
    """A cycle that is shown to a person, and the folder in which it was asked for."""
    folder = tmp_path_factory.mktemp("shown")
    bench = ("cycle", "--machine", "bench", "--compensation", "none", "--seed", "12")
    ran = unrecorded(*bench, cwd=folder)
    assert ran.returncode == 0, ran.stderr
    return ran, folder


def test_summary_says_in_silico_and_where_the_files_are(shown: tuple[Ran, Path]) -> None:
    ran, folder = shown
    words = "".join(ran.stdout.split())  # a long path is broken where its line ends
    (run,) = (folder / "runs").iterdir()
    report = f"runs/{run.name}/report.html"
    for expected in ("Completed", "digital twin", "not a medical device", report):
        assert "".join(expected.split()) in words
    # What is about to run goes to stderr, with all progress: a refusal may still come.
    assert ran.stderr.splitlines() == [
        "One suction cycle on the digital twin: machine bench, protocol paper (the bench's), "
        "approach travel, compensation none, seed 12"
    ]


def test_default_folder_is_under_runs_and_named_by_the_seed(shown: tuple[Ran, Path]) -> None:
    (run,) = (shown[1] / "runs").iterdir()
    assert run.name.endswith("Z-12")
    assert (run / "report.html").is_file()


BAD = [
    (("cycle", "--machine", "bensh"), "bench"),
    (("cycle", "--protocol", "papper"), "paper"),
    (("cycle", "--approach", "magic"), "travel"),
    (("cycle", "--compensation", "exact"), "exact-inverse"),
    (("cycle", "--patient", "adult"), "adult-icu"),
    (("cycle", "--protocol", "paper", "--machine", "clinical"), "bench only"),
    (("cycle", "--protocol", "adult", "--machine", "bench"), "--machine clinical"),
    (("cycle", "--protocol", "adult", "--patient", "neonate"), "neonate"),
    (("cycle", "--protocol", "paediatric"), "adult"),
    (("cycle", "--seed", "-1"), "--seed"),
    (("cycle", "--seed", "1.5"), "--seed"),
    (("cycle", "--taught", "150"), "50 mm beyond the most plausible"),
    (("cycle", "--taught", "12"), "18 mm short of the least plausible"),
    (("cycle", "--taught", "nan"), "--taught"),
    (("cycle", "--taught", "70", "--protocol", "paper"), "travel_mm"),
    (("cycle", "--pace", "-2"), "--pace"),
    (("cycle", "--pace", "nan"), "--pace"),
    (("cycle", "--nonsense"), "--nonsense"),
    (("cylce",), "cycle"),
    (("cycle", "--protocol", "missing.toml"), "missing.toml"),
    (("cycle", "surplus"), "surplus"),
]


@pytest.mark.parametrize(("arguments", "named"), BAD, ids=[" ".join(a) for a, _ in BAD])
def test_bad_option_is_one_plain_line(
    arguments: tuple[str, ...], named: str, tmp_path: Path
) -> None:
    ran = opensuction(*arguments, "--json", cwd=tmp_path)
    assert_refused(ran, named, tmp_path)


def assert_refused(ran: Ran, named: str, folder: Path, left: int = 0) -> None:
    assert ran.returncode == 2
    assert ran.stdout == ""
    lines = ran.stderr.strip().splitlines()
    assert lines[-1].startswith("opensuction: ")
    assert named in lines[-1]
    assert "Traceback" not in ran.stderr
    assert len(list(folder.iterdir())) == left


BAD_PROTOCOLS: list[tuple[dict[str, object], str]] = [
    ({"travel_mm": None}, "travel_mm"),
    ({"traval_mm": 3.0}, "travel_mm"),
    ({"dwell_s": "nan"}, "dwell_s"),
    ({"dwell_s": "inf"}, "dwell_s"),
    ({"dwell_s": "'nine'"}, "dwell_s"),
    ({"dwell_s": -1.0}, "dwell_s"),
    ({"vacuum_mmhg": 200.0}, "150"),
    ({"bench_only": 1.0}, "bench_only"),
    ({"travel_mm": True}, "travel_mm"),
    ({"cap_mm": 91.0}, "95"),
    ({"dwell_s": 20.0}, "budget"),
    ({"insertion_mm_per_s": 25.0}, "17 mm/s"),
    ({"dwell_s": 2.5}, "stroke"),
]


@pytest.mark.parametrize(
    ("changes", "named"), BAD_PROTOCOLS, ids=[str(changes) for changes, _ in BAD_PROTOCOLS]
)
def test_bad_protocol_file_is_one_plain_line(
    changes: dict[str, object], named: str, tmp_path: Path
) -> None:
    protocol_file(tmp_path, **changes)
    ran = opensuction("cycle", "--protocol", "protocol.toml", "--json", cwd=tmp_path)
    assert_refused(ran, named, tmp_path, left=1)


def test_malformed_toml_names_file_and_line(tmp_path: Path) -> None:
    (tmp_path / "broken.toml").write_text("travel_mm = 90.0\ncap_mm = = 3\n")
    ran = opensuction("cycle", "--protocol", "broken.toml", "--json", cwd=tmp_path)
    assert_refused(ran, "broken.toml", tmp_path, left=1)
    assert "line 2" in ran.stderr


def test_protocol_file_with_whole_numbers_runs(tmp_path: Path) -> None:
    protocol_file(tmp_path, travel_mm=80, cap_mm=90)
    ran = unrecorded(
        "cycle", "--protocol", "protocol.toml", "--json", "--compensation", "none", cwd=tmp_path
    )
    assert ran.returncode == 0, ran.stderr
    assert json.loads(ran.stdout)["tip"]["target_mm"] == 80.0


def test_folder_with_something_in_it_needs_force(tmp_path: Path) -> None:
    (tmp_path / "kept").mkdir()
    (tmp_path / "kept" / "notes.txt").write_text("mine")
    arguments = (*PAPER_CYCLE, "--compensation", "none", "--json", "--out", "kept")
    ran = opensuction(*arguments, cwd=tmp_path)
    assert_refused(ran, "--force", tmp_path, left=1)
    forced = unrecorded(*arguments, "--force", cwd=tmp_path)
    assert forced.returncode == 0, forced.stderr
    assert (tmp_path / "kept" / "notes.txt").read_text() == "mine"
    assert (tmp_path / "kept" / "report.html").is_file()


def test_out_that_is_a_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "taken").write_text("mine")
    ran = opensuction("cycle", "--json", "--out", "taken", cwd=tmp_path)
    assert_refused(ran, "taken", tmp_path, left=1)


def test_out_that_cannot_be_made_is_refused(tmp_path: Path) -> None:
    # A file in the way stops every user, root too, unlike missing permission.
    (tmp_path / "file").write_text("")
    ran = opensuction("cycle", "--json", "--out", "file/below", cwd=tmp_path)
    assert_refused(ran, "file/below", tmp_path, left=1)


def test_contact_stops_at_the_carina_on_the_bench(tmp_path: Path) -> None:
    ran = unrecorded(
        *PAPER_CYCLE, "--approach", "contact", "--compensation", "none", "--json", cwd=tmp_path
    )
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["tip"]["target_mm"] == 65.0
    assert abs(data["tip"]["stop_error_mm"]) < 1.5  # Table II: at most 1.34
    assert 0.08 < data["carina_force_peak_n"] < 0.3


@pytest.mark.parametrize(
    ("protocol", "patient", "limit_s"),
    [
        ("adult", "adult-icu", 15.0),
        pytest.param("adult", "adult-ards", 15.0, marks=pytest.mark.soak),
        pytest.param("paediatric", "child-10kg", 5.0, marks=pytest.mark.soak),
        ("paediatric", "neonate", 5.0),
    ],
)
def test_a_patient_is_suctioned_by_its_age_s_protocol_within_the_guideline(
    protocol: str, patient: str, limit_s: float, tmp_path: Path
) -> None:
    ran = unrecorded("cycle", "--patient", patient, "--json", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    assert f"protocol {protocol} (by the patient's age), " in ran.stderr
    data = json.loads(ran.stdout)
    assert data["protocol"] == protocol
    assert data["machine"] == "clinical"
    assert data["patient"] == patient
    assert data["timing"]["negative_pressure_s"] <= limit_s
    assert data["timing"]["in_airway_s"] <= 30.0
    assert data["tip"]["deepest_mm"] <= data["anatomy"]["cap_mm"]
    assert all(check["ok"] for check in data["checks"])
    assert 80.0 < data["spo2_nadir_percent"] <= 100.0
    assert data["lung_volume_loss_ml"] > 0.0


def test_a_bench_has_the_paper_s_protocol(shown: tuple[Ran, Path]) -> None:
    ran, folder = shown
    assert "protocol paper (the bench's), " in ran.stderr
    (run,) = (folder / "runs").iterdir()
    assert json.loads((run / "cycle.json").read_text())["protocol"] == "paper"


def test_a_measured_length_is_what_the_cycle_is_fitted_to(tmp_path: Path) -> None:
    ran = unrecorded("cycle", "--taught", "57", "--json", cwd=tmp_path)
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    assert data["taught_mm"] == 57.0
    assert data["teaching"]["source"] == "given"
    assert data["tip"]["target_mm"] == 44.0  # 10 mm short of it, and 3 that a hand teaches too deep
    assert data["check"]["passed"] is True
    assert data["check"]["failed_item"] is None
    assert [item["name"] for item in data["check"]["items"]] == [
        item.name.lower().replace("_", "-") for item in ORDER
    ]


def test_a_day_has_its_cycles_in_the_json_and_a_page_of_its_own(tmp_path: Path) -> None:
    ran = opensuction(
        "cycle", "--repeat", "3", "--every", "60", "--json", "--out", "day", cwd=tmp_path
    )
    assert ran.returncode == 0, ran.stderr
    data = json.loads(ran.stdout)
    day = data["day"]
    assert data.keys() >= KEYS
    assert [cycle["outcome"] for cycle in day["cycles"]] == ["completed"] * 3
    assert [round(cycle["start_min"]) for cycle in day["cycles"]] == [0, 60, 120]
    assert day["removed_ml"] == pytest.approx(sum(c["removed_ml"] for c in day["cycles"]))
    assert data["secretion"]["removed_ml"] == pytest.approx(day["cycles"][-1]["removed_ml"])
    assert sorted(file.name for file in (tmp_path / "day").iterdir()) == [
        "cycle-001.html",
        "cycle-002.html",
        "cycle-003.html",
        "cycle.json",
        "day.html",
        "recording.mcap",
        "report.html",
    ]
    assert [cycle["report"] for cycle in day["cycles"]] == [f"cycle-00{n}.html" for n in (1, 2, 3)]
    assert [cycle["harm"] for cycle in day["cycles"]] == [[], [], []]
    page = (tmp_path / "day" / "day.html").read_text(encoding="utf-8")
    assert '<a href="cycle-002.html">2</a>' in page
    assert "cycle 3 of 3" in ran.stderr


def test_a_completed_cycle_that_broke_a_bound_of_the_patient_fails(tmp_path: Path) -> None:
    options = ("--patient", "adult-ards", "--fault", "desaturation@inserting")
    ran = unrecorded("cycle", *options, "--json", "--out", "fell", cwd=tmp_path)
    assert ran.returncode == 1, ran.stderr
    data = json.loads(ran.stdout)
    assert data["outcome"] == "completed"
    assert "saturation" in data["harm"]
    assert data["broken_bounds"][0]["name"] == data["harm"][0]
    page = (tmp_path / "fell" / "report.html").read_text(encoding="utf-8")
    assert "PATIENT AT RISK: oxygen saturation fell below its bound" in page


LEARNING = ("--approach", "contact", "--repeat", "3", "--every", "60", "--self-calibrate")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--repeat", "3"), "needs --every"),
        (("--every", "60"), "says nothing without --repeat"),
        (("--repeat", "3", "--every", "5"), "at least 15 min"),
        (("--repeat", "3", "--every", "60", "--protocol", "paper"), "the bench has none"),
        (("--self-calibrate", "--approach", "contact"), "add --repeat 2 or more"),
        ((*LEARNING[2:], "--compensation", "none"), "use another, for example preview"),
        (("--tip-shift", "11"), "should be -10 to 10 mm"),
        (("--tip-shift", "nan"), "should be -10 to 10 mm"),
        (("--gap-scale", "3"), "should be 0.5 to 1.5"),
        (("--gap-scale", "nan"), "should be 0.5 to 1.5"),
    ],
)
def test_what_is_no_day_is_refused(tmp_path: Path, options: tuple[str, ...], words: str) -> None:
    ran = opensuction("cycle", *options, cwd=tmp_path)
    assert (ran.returncode, ran.stdout) == (2, "")
    assert words in ran.stderr
    assert ran.stderr.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


def test_a_gap_out_of_range_ends_the_day_with_an_alarm(tmp_path: Path) -> None:
    ran = unrecorded("cycle", *LEARNING, "--gap-scale", "0.6", "--json", "--out", "d", cwd=tmp_path)
    assert ran.returncode == 1, ran.stderr
    data = json.loads(ran.stdout)
    assert data["compensation"] == "preview"  # the default
    assert data["outcome"] == "completed"
    assert [alarm["condition"] for alarm in data["alarms"]] == ["calibration-out-of-range"]
    assert data["day"]["cycles"][0]["gap"]["in_range"] is False
    assert "Cycle 2 of 3 was refused" in ran.stderr
