import re

import numpy as np
import pytest

from opensuction.report import sheet
from opensuction.report.sheet import Curve, Level, Plot, Section, Sheet, Table
from tests.report import sheet_example
from tests.report.page_data import payload


def test_page_needs_nothing_from_elsewhere() -> None:
    html = sheet.render(sheet_example.sheet())
    assert not re.search(r"""(src|href)\s*=\s*["'](?!data:|#)""", html)
    assert "not a medical device" in html


def test_text_is_escaped_wherever_it_stands() -> None:
    evil = "<script>alert(1)</script>"
    page = Sheet(
        evil,
        evil,
        True,
        evil,
        ((evil, evil),),
        (Section(evil, (evil,), (Table(evil, (evil,), ((evil,),)),)),),
    )
    plotted = Plot(evil, evil, evil, (Curve(evil, np.zeros(2)),), np.arange(2.0))
    html = sheet.render(page._replace(sections=(*page.sections, Section("", plots=(plotted,)))))
    assert evil not in html
    assert payload(html)["plot-2-1"]["x_label"] == evil


def test_extremes_and_ends_of_every_curve_survive_thinning() -> None:
    x = np.linspace(0.0, 10.0, 50_001)
    spiked = np.sin(x)
    spiked[33_333] = 7.0
    spiked[12_345] = -5.0
    plot = Plot("", "", "", (Curve("a", spiked), Curve("b", np.cos(x))), x)
    data = sheet.to_plain(plot)
    assert len(data["x"]) < 3000
    assert data["x"][0] == 0.0
    assert data["x"][-1] == 10.0
    assert max(data["curves"][0]["y"]) == 7.0
    assert min(data["curves"][0]["y"]) == -5.0


def test_a_loop_keeps_its_own_abscissa() -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 5001)
    plot = Plot("", "", "", (Curve("loop", np.sin(angle), x=np.cos(angle)),))
    curve = sheet.to_plain(plot)["curves"][0]
    assert np.hypot(curve["x"], curve["y"]) == pytest.approx(1.0, abs=1e-3)
    assert min(curve["x"]) == pytest.approx(-1.0, abs=1e-3)


def test_a_curve_without_abscissa_is_a_mistake_of_the_caller() -> None:
    with pytest.raises(ValueError, match="curve 'lost' of 'here' has no abscissa"):
        sheet.to_plain(Plot("here", "", "", (Curve("lost", np.zeros(3)),)))


def test_missing_values_are_null_and_the_rest_is_exact_to_the_eye() -> None:
    y = np.array([0.123456789, np.nan, 2.0, np.inf])
    data = sheet.to_plain(
        Plot("", "", "", (Curve("", y),), np.arange(4.0), levels=(Level(1, "l"),))
    )
    assert data["curves"][0]["y"] == [0.1235, None, 2.0, None]
    assert data["levels"] == [{"value": 1, "name": "l"}]


@pytest.mark.parametrize(
    ("value", "text", "kind"),
    [
        (True, "✓ yes", "good"),
        (np.bool_(False), "✕ no", "bad"),
        (None, "-", "number"),
        (float("nan"), "-", "number"),
        (np.float64(0.123456), "0.1235", "number"),
        (12, "12", "number"),
        ("words", "words", ""),
    ],
)
def test_cells(value: object, text: str, kind: str) -> None:
    assert sheet.cell(value) == {"text": text, "kind": kind}
