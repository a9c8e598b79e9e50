"""Does Python say what the command says? BEELINE is the place of the command."""

import json
import math
import os
import pathlib
import shutil
import subprocess
import threading
import time

import numpy as np
import pytest

import beeline
from beeline import BeelineError, Campaign, Equation, Robot, Run

MYSTERY = pathlib.Path(__file__).parents[2] / "examples" / "mystery-robot"
REAL = MYSTERY.parent / "optiodom"
COMMAND = os.environ.get("BEELINE") or shutil.which("beeline")


def command(*arguments):
    """What the command prints."""
    assert COMMAND, "BEELINE is not set: cargo xtask wheel does that"
    done = subprocess.run([COMMAND, *map(str, arguments)], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def mystery():
    return Campaign.from_folder(MYSTERY)


@pytest.fixture(scope="module")
def explanation(mystery):
    return mystery.explain()


def arrays(campaign):
    """A campaign as arrays, without the numbers of its runs."""
    tracks = {track.run: track for track in campaign.predict()}
    for name in campaign.runs:
        t_s, left, right = campaign.wheels(name)
        track = tracks[name]
        poses = (track.t_s, track.x_m, track.y_m, track.heading_rad)
        yield Run(t_s, left, right, *poses, name=name.split("_", 1)[1])


@pytest.mark.parametrize("folder", [MYSTERY, REAL], ids=["mystery", "real"])
def test_explain_is_what_the_command_prints(folder):
    assert Campaign.from_folder(folder).explain().json == json.loads(command("explain", folder, "--format", "json"))


def test_a_tolerance_is_judged_by_as_with_the_command(mystery):
    printed = command("explain", MYSTERY, "--format", "json", "--tolerance", "20mm")
    told = mystery.explain(tolerance_m=0.02)
    assert told.json == json.loads(printed) and not told.effects[0].matters


def test_compare_is_what_the_command_prints(mystery):
    assert mystery.compare().json == json.loads(command("compare", MYSTERY, "--format", "json"))


def test_fit_is_what_the_command_prints_and_a_model_goes_to_the_command_and_back(mystery, tmp_path):
    folder = tmp_path / "mystery"
    shutil.copytree(MYSTERY, folder)
    equation = "dtheta/ds = k * v"
    told = command("model", "add", "scrub", "--custom", equation, "--name", "mine", folder, "--json")
    fit = mystery.fit(["scrub"], custom=[Equation(equation, name="mine")])
    assert fit.json["effects"] == json.loads(told)["effects"]
    fit = Campaign.from_folder(folder).fit(["scrub"], custom=[])
    fit.model.write(folder / "model.toml")
    printed = json.loads(command("compare", folder, "--format", "json"))
    # A file has six digits or so.
    of_file, of_fit = printed["comparison"]["position_m"]["rms"], mystery.compare(fit).position_m.rms
    assert math.isclose(of_file, of_fit, rel_tol=1e-6)
    assert printed["model"] == ["scrub"] == beeline.Model.read(folder / "model.toml").effects()
    assert fit["scrub"].parameters[0].sigma > 0
    with pytest.raises(KeyError):
        fit["nothing"]


def test_the_mystery_is_an_effect_with_its_interval(explanation):
    (effect,) = explanation.effects
    assert effect.effect == "speed_growth" and effect.matters
    parameter = effect.parameters[0]
    assert parameter.low95 < parameter.value < parameter.high95 and effect[parameter.name] is parameter
    assert explanation.verdict.startswith("One effect is missing")
    before, after = explanation.baseline.cross_validated, effect.errors.cross_validated
    assert after.position_rms_m < before.position_rms_m / 2
    assert explanation.floor.position_rms_m <= after.position_rms_m


def test_predictions_are_arrays_whose_error_is_that_of_the_comparison(mystery, explanation):
    tracks = mystery.predict(explanation)
    compared = {run.name: run for run in mystery.compare(explanation).runs}
    assert [track.run for track in tracks] == list(mystery.runs)
    for track in tracks:
        assert track.t_s.dtype == np.float64 and track.t_s.shape == track.predicted_x_m.shape
        # The start of a run depends a little on the noise, which `compare` estimates afresh.
        assert math.isclose(track.position_rms_m, compared[track.run].position_m.rms, rel_tol=0.02), track.run
    nominal = mystery.predict()
    assert sum(track.position_rms_m for track in tracks) < sum(track.position_rms_m for track in nominal) / 2


def test_arrays_give_what_the_folder_gives(mystery, explanation, tmp_path):
    # With the noise of the folder: learnt, it would be another one.
    robot = Robot(0.036, 0.372, position_sigma_m=0.001, heading_sigma_rad=0.002)
    made = Campaign.from_arrays(robot, arrays(mystery), folder=tmp_path / "made")
    found = made.explain().effects
    assert [effect.effect for effect in found] == ["speed_growth"]
    expected, value = explanation.effects[0].parameters[0], found[0].parameters[0]
    assert abs(value.value - expected.value) < 0.02 * expected.sigma
    printed = json.loads(command("explain", tmp_path / "made", "--format", "json"))
    assert printed == made.explain().json


def test_a_run_that_is_held_out_counts_in_no_fit(mystery):
    runs = list(arrays(mystery))
    runs[0] = Run(**{**runs[0].__dict__, "held_out": True})
    made = Campaign.from_arrays(Robot(0.036, 0.372), runs)
    fit = made.fit(["speed_growth"])
    assert fit.held_out.runs == 1
    assert made.predict(fit)[-1].held_out


def test_a_bag_gives_what_the_campaign_gives(explanation, tmp_path):
    bag = tmp_path / "drive.mcap"
    command("export", MYSTERY, "--to", "mcap", "-o", bag)
    read = Campaign.from_bag(bag, wheel_radius_m=0.036, track_width_m=0.372)
    (effect,) = read.explain().effects
    expected = explanation.effects[0].parameters[0]
    assert abs(effect.parameters[0].value - expected.value) < expected.sigma


@pytest.mark.parametrize(
    "call, words",
    [
        (lambda: Campaign.from_folder("no-such-folder"), "robot.toml: there is no such file"),
        (lambda: Campaign.from_bag("no-such.mcap"), "no-such.mcap"),
        (lambda: Campaign.from_folder(MYSTERY).fit(["scrubb"]), "did you mean scrub?"),
        (lambda: Campaign.from_folder(MYSTERY).fit(custom=["dtheta/ds = k * nonsense("]), "the equation"),
        (lambda: Campaign.from_folder(MYSTERY).fit(custom=[Equation("dtheta/ds = k", units={"q": "m"})]), "no parameter `q`"),
        (lambda: Campaign.from_arrays(Robot(0.036, 0.372), []), "no runs"),
        (lambda: Campaign.from_arrays(Robot(-1.0, 0.372), []), "wheel_radius_m"),
        (
            lambda: Campaign.from_arrays(Robot(0.036, 0.372), [Run([0, 1], [0, 1], [0, 1, 2], [0, 1], [0, 1], [0, 1])]),
            "right_rad has the shape",
        ),
        (
            lambda: Campaign.from_arrays(Robot(0.036, 0.372), [Run([0, 0], [0, 1], [0, 1], [0, 1], [0, 1], [0, 1])]),
            "run",
        ),
    ],
)
def test_a_problem_says_where_it_is_and_what_to_try(call, words):
    with pytest.raises(BeelineError, match=words.replace("?", r"\?")):
        call()


def test_another_thread_goes_on_while_a_campaign_is_explained(mystery):
    worker = threading.Thread(target=mystery.explain)
    longest, before = 0.0, time.perf_counter()
    worker.start()
    while worker.is_alive():
        time.sleep(0.001)
        now = time.perf_counter()
        longest, before = max(longest, now - before), now
    worker.join()
    # Holding the lock, this thread would have stood still for nearly all of it.
    single = time.perf_counter()
    mystery.explain()
    assert longest < 0.5 * (time.perf_counter() - single), longest


def test_results_cannot_be_changed(explanation):
    with pytest.raises(AttributeError):
        explanation.verdict = "nothing"
    with pytest.raises(AttributeError):
        explanation.effects[0].parameters[0].value = 0.0


def test_every_name_of_the_compiled_part_has_a_type():
    import ast

    from beeline import _beeline

    stub = pathlib.Path(beeline.__file__).with_name("_beeline.pyi").read_text()
    typed = {node.name: node for node in ast.parse(stub).body if isinstance(node, ast.ClassDef | ast.FunctionDef)}
    public = {name for name in dir(_beeline) if not name.startswith("_")}
    assert public == {name for name in typed if not name.startswith("_")}
    for name in ("Campaign", "Model"):
        methods = {one.name for one in typed[name].body if isinstance(one, ast.FunctionDef)}
        assert methods == {one for one in dir(getattr(_beeline, name)) if not one.startswith("_")}
