"""A comparison as a script has it."""

from collections.abc import Iterator
from typing import Any

import pytest

import opensuction as osn
from opensuction.identification import workbench
from opensuction.identification.estimator import nonlinear
from opensuction.identification.workbench import MODELS
from tests.library.recordings import bench


@pytest.fixture(scope="module")
def compared() -> Iterator[osn.Comparison]:
    """Of a few models, those that are quick to fit."""
    few = ("modified-dahl", "dahl", "prandtl-ishlinskii")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(workbench, "MODELS", {name: MODELS[name] for name in few})
        yield osn.compare(*bench(300), purpose="predict", holdout=0.25)


def test_the_recommended_fit_comes_first_with_its_reasons(compared: osn.Comparison) -> None:
    assert compared.recommended is compared.fits[0]
    assert compared.recommended.model == "prandtl-ishlinskii"
    assert compared.recommended.summary["recommended"] is True
    assert compared.purpose == "predict"
    assert compared.reasons
    assert compared.reasons == tuple(compared.summary["models"][0]["reasons"])
    assert [one["model"] for one in compared.summary["models"]] == [one.model for one in compared]
    assert len(compared) == 3
    assert compared.summary["left_out"] == {}


def test_each_fit_has_the_object_that_it_would_have_alone(compared: osn.Comparison) -> None:
    alone = osn.identify(*bench(300), "dahl", holdout=0.25).summary
    among = compared["dahl"].summary
    assert among.keys() == alone.keys()
    assert among["parameters"] == alone["parameters"]
    assert among["recording"] == alone["recording"]


def test_a_model_is_found_by_its_name(compared: osn.Comparison) -> None:
    assert compared["dahl"].model == "dahl"
    with pytest.raises(KeyError):
        compared["none"]


def test_it_is_shown_as_a_table(compared: osn.Comparison) -> None:
    heading, first, *others = repr(compared).splitlines()
    assert heading.startswith("model")
    assert first.startswith("prandtl-ishlinskii")
    assert first.endswith("recommended")
    assert len(others) == 2
    assert "<table>" in compared._repr_html_()
    assert compared.reasons[0][:20] in compared._repr_html_()


def test_a_script_pays_for_one_fit(monkeypatch: pytest.MonkeyPatch) -> None:
    done, fit = list[Any](), nonlinear.FITS["dahl"]

    def count(*given: Any) -> Any:
        done.append(given)
        return fit(*given)

    monkeypatch.setitem(nonlinear.FITS, "dahl", count)
    assert osn.identify(*bench(300), "dahl").summary["fit_seconds"] is None
    assert len(done) == 1
