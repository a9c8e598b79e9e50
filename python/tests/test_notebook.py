"""The notebook and the drawings, which need matplotlib: `cargo xtask peers`."""

import pathlib

import pytest

pytest.importorskip("matplotlib").use("Agg")
nbformat = pytest.importorskip("nbformat")
nbclient = pytest.importorskip("nbclient")

import beeline
from beeline import plot

FOLDER = pathlib.Path(__file__).parents[1]


def test_the_notebook_finds_the_effect():
    notebook = nbformat.read(FOLDER / "mystery.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "outputs are not kept in the repository"
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": FOLDER}}).execute()
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    outputs = [output for cell in cells for output in cell.outputs]
    printed = "".join(output.get("text", "") for output in outputs)
    assert "One effect is missing" in printed and "speed_growth: " in printed
    pictures = [output for output in outputs if "image/png" in output.get("data", {})]
    assert len(pictures) == 3


def test_drawings_show_what_was_found():
    campaign = beeline.Campaign.from_folder(FOLDER.parent / "examples" / "mystery-robot")
    explanation = campaign.explain()
    bars = plot.waterfall(explanation).patches
    millimetres = [1e3 * explanation.baseline.cross_validated.position_rms_m]
    millimetres += [1e3 * one.errors.cross_validated.position_rms_m for one in explanation.effects]
    assert [bar.get_width() for bar in bars[:-1]] == pytest.approx(millimetres)
    (label,) = plot.intervals(explanation).get_yticklabels()
    assert label.get_text().startswith("speed_growth: ")
    track = campaign.predict()[0]
    measured = plot.path(track, track).lines[0]
    assert measured.get_xdata() == pytest.approx(track.x_m, nan_ok=True)
