# SPDX-License-Identifier: MIT
"""What a notebook shows and completes, figures of channels by name, and runs as flat tables."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest

import gyrostat as gs
from gyrostat import papers
from gyrostat.papers.claims import Evaluation
from gyrostat.papers.reproduction import Reproduction


def cells(html: str) -> list[list[str]]:
    """Rows of all tables, of HTML that is well formed."""
    return [["".join(cell.itertext()) for cell in row] for row in ET.fromstring(html).iter("tr")]


def test_a_result_is_shown_with_its_metrics_and_channels(result: gs.Result) -> None:
    rows = cells(result._repr_html_())
    shown = {row[0]: row[1:] for row in rows}
    assert shown["pointing error"] == [f"{np.degrees(result.metrics.pointing_error):.4g} deg"]
    assert set(result) <= set(shown)
    assert shown["truth.omega_BN_B"][:2] == ["3", "rad/s"]


def test_metrics_are_a_table(result: gs.Result) -> None:
    rows = cells(result.metrics._repr_html_())
    assert [row[0].replace(" ", "_") for row in rows[1:]] == list(result.metrics.to_dict())


def test_a_scenario_shows_what_was_written(scenario: gs.Scenario) -> None:
    shown = dict(cells(scenario.replace(name="<b>bold</b>")._repr_html_()))
    assert shown["controller"] == "mrp_feedback"
    assert shown["faults.0"] == "loss_of_effectiveness, actuator = 2, remaining = 0.4, t_on = 5"
    assert shown["duration"] == "30"
    assert "&lt;b&gt;bold" in scenario.replace(name="<b>bold</b>")._repr_html_()


def test_a_python_component_is_shown_by_its_class(scenario: gs.Scenario) -> None:
    class Mine:
        def step(self, x, det, ref, last):
            return np.zeros(3)

    assert dict(cells(scenario.replace(controller=Mine())._repr_html_()))["controller"] == "Mine, a Python object"


def test_a_component_shows_its_parameters() -> None:
    fault = gs.faults.Bias(actuator=1, torque=gs.waveforms.Sine(amplitude=0.1, omega=2.0))
    shown = dict(cells(fault._repr_html_()))
    assert shown["actuator"] == "1"
    assert shown["torque"].startswith("sine, amplitude = 0.1")


def test_a_reproduction_lists_what_is_outside_first() -> None:
    paper = papers.load("li2018")
    claims = paper.claims
    inside, outside = (
        Evaluation(claims[0], measured, "") for measured in (claims[0].accept[0], float(claims[0].accept[1]) + 1.0)
    )
    rows = cells(Reproduction(paper, (inside, outside), {}, {})._repr_html_())
    assert [row[0] for row in rows[1:]] == ["outside", "ok"]
    assert rows[1][1] == claims[0].id


def test_channels_keys_and_scenarios_are_completed(result: gs.Result, scenario: gs.Scenario) -> None:
    for name in result._ipython_key_completions_():
        assert result[name].shape[0] == len(result)
    assert {"truth.omega_BN_B", "omega_BN_B"} <= set(result._ipython_key_completions_())
    for key in scenario._ipython_key_completions_():
        scenario[key]
    assert {"controller.K", "faults.0.remaining", "vehicle.J_B"} <= set(scenario._ipython_key_completions_())
    assert gs.scenarios._ipython_key_completions_() == list(gs.scenarios)
    assert {"scenarios", "Scenario", "faults"} <= set(dir(gs))


def test_a_scenario_tells_its_values_defaults_too(scenario: gs.Scenario) -> None:
    assert scenario["faults.0.remaining"] == 0.4
    assert scenario["controller.K"] == pytest.approx(1.642, rel=1e-3)  # the default of docs/components/mrp_feedback.md
    changed = scenario.replace(**{"controller.K": 2.0})
    assert changed["controller.K"] == 2.0
    with pytest.raises(KeyError, match=r"did you mean 'controller\.K'"):
        scenario["controller.KK"]


def test_the_shelf_holds_the_shipped_scenarios() -> None:
    assert gs.scenarios["wheel2_degraded"] == gs.Scenario.load("wheel2_degraded")
    assert dict(cells(gs.scenarios._repr_html_()))["ftc_4rw"] == gs.scenarios["ftc_4rw"].description
    with pytest.raises(KeyError, match="did you mean 'ftc_4rw'"):
        gs.scenarios["ftc_4r"]


def test_a_plot_draws_what_is_named(result: gs.Result, tmp_path: Path) -> None:
    figure = result.plot("u", "error.angle")
    np.testing.assert_array_equal(figure.data["allocation.u"], result["allocation.u"])
    assert [axis.get_ylabel() for axis in figure.axes] == ["allocation.u (N m)", "error.angle (rad)"]
    assert [text.get_text() for text in figure.axes[0].get_legend().get_texts()] == [f"actuator {i}" for i in range(4)]
    assert figure._repr_png_().startswith(b"\x89PNG")
    assert figure.save(tmp_path / "two.svg").exists()
    with pytest.raises(KeyError, match=r"did you mean 'error\.angle'"):
        result.plot("error.angl")


def test_a_data_frame_has_a_column_a_number(result: gs.Result) -> None:
    frame = result.to_dataframe()
    assert frame.index.name == "time"
    np.testing.assert_array_equal(frame.index, result.t)
    np.testing.assert_array_equal(frame["truth.omega_BN_B.y"], result["omega_BN_B"][:, 1])
    np.testing.assert_array_equal(frame["truth.q_NB.w"], result["q_NB"][:, 0])
    np.testing.assert_array_equal(frame["allocation.u.3"], result["u"][:, 3])
    assert list(result.to_dataframe(["error.angle", "u"])) == ["error.angle", *(f"allocation.u.{i}" for i in range(4))]


def test_parquet_and_csv_read_back_exactly(result: gs.Result, tmp_path: Path) -> None:
    import pandas as pd
    import pyarrow.parquet

    chosen = ["error.angle", "truth.q_NB"]
    frame = result.to_dataframe(chosen)
    table = pyarrow.parquet.read_table(result.to_parquet(tmp_path / "run", chosen))
    assert table.schema.field("error.angle").metadata == {b"unit": b"rad"}
    assert b"loss_of_effectiveness" in table.schema.metadata[b"scenario"]
    pd.testing.assert_frame_equal(table.to_pandas().set_index("time"), frame)
    rows = np.loadtxt(result.to_csv(tmp_path / "run.csv", chosen), delimiter=",", skiprows=1)
    np.testing.assert_array_equal(rows, frame.reset_index().to_numpy())
    assert (tmp_path / "run.csv").read_text().splitlines()[0].replace('"', "") == ",".join(["time", *frame])
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run.csv", "run.parquet"]


def test_wrong_tables_are_one_line_and_write_nothing(result: gs.Result, tmp_path: Path) -> None:
    with pytest.raises(gs.InputError, match=r"is written as \.parquet; write that ending, or none"):
        result.to_parquet(tmp_path / "run.csv")
    with pytest.raises(gs.InputError, match="cannot be written"):
        result.to_csv(tmp_path / "nowhere" / "run.csv")
    with pytest.raises(KeyError, match="no channel 'angle2'"):
        result.to_csv(tmp_path / "run.csv", ["angle2"])
    with pytest.raises(gs.InputError, match=r"write \['error.angle'\]"):
        result.to_dataframe("error.angle")
    assert not list(tmp_path.iterdir())


def test_help_of_the_package_begins_with_what_to_do() -> None:
    import pydoc

    text = pydoc.plain(pydoc.render_doc(gs))
    assert "gs.scenarios" in text[:1500]
    for name in ("Scenario", "recommended", "Campaign", "to_dataframe"):
        assert name in text
    undocumented = [name for name in gs.__all__ if name != "__version__" and not getattr(gs, name).__doc__]
    assert not undocumented
