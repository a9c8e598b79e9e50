"""Is a fleet judged as `beeline fleet` judges it?"""

import json
import pickle
import shutil

import numpy as np

from beeline import Campaign, Robot, Run, fleet
from test_beeline import MYSTERY, command

RADIUS_M, TRACK_M = 0.036, 0.372


def record(folder, ratio, seed, bend=0.0):
    """A robot with a right wheel that is larger, and that bends with the square of its speed, driven as the mystery was."""
    source = Campaign.from_folder(MYSTERY)
    noise = np.random.default_rng(seed)
    runs = []
    for name in source.runs[:8]:
        t_s, left, right = source.wheels(name)
        steps = RADIUS_M * (1 - ratio / 2) * np.diff(left), RADIUS_M * (1 + ratio / 2) * np.diff(right)
        travel = (steps[0] + steps[1]) / 2
        turns = (steps[1] - steps[0]) / TRACK_M + bend * travel**2 / np.diff(t_s)
        heading = np.concatenate([[0], np.cumsum(turns)])
        middle = (heading[1:] + heading[:-1]) / 2
        x, y = (np.concatenate([[0], np.cumsum(travel * of(middle))]) for of in (np.cos, np.sin))
        seen = [values[::10] + sigma * noise.normal(size=t_s[::10].size) for values, sigma in ((x, 1e-3), (y, 1e-3), (heading, 2e-3))]
        runs.append(Run(t_s, left, right, t_s[::10], *seen, name=name.split("_", 1)[1]))
    Campaign.from_arrays(Robot(RADIUS_M, TRACK_M, name=folder.parent.name), runs, folder=folder)


def test_the_parts_give_what_the_command_gives(tmp_path):
    ratios = {"ada": 0.008, "bob": 0.0082, "cyd": 0.0079, "dan": 0.04}
    for number, (name, ratio) in enumerate(ratios.items()):
        for date in ("2025-01-10", "2025-03-10"):
            record(tmp_path / name / date, ratio, number)
    told = json.loads(command("fleet", tmp_path, "--json"))
    folders = sorted(tmp_path.glob("*/*"))
    campaigns = [Campaign.from_folder(folder) for folder in folders]
    effects = fleet.common_effects(campaign.explain() for campaign in campaigns)
    assert effects == list(dict.fromkeys(one["effect"] for one in told["kinds"][0]["parameters"]))
    values = {effect: [] for effect in effects}
    days = {"2025-01-10": 20_098.0, "2025-03-10": 20_157.0}
    for folder, campaign in zip(folders, campaigns):
        fit = campaign.fit(effects)
        for effect in effects:
            parameter = fit[effect].parameters[0]
            robot = list(ratios).index(folder.parent.name)
            values[effect].append((robot, days[folder.name], parameter.value, parameter.sigma))
    judged = fleet.judge(values)
    for by_command in told["kinds"][0]["parameters"]:
        ours = judged[by_command["effect"]]
        assert (ours.mean, ours.spread, ours.alike) == tuple(by_command[key] for key in ("mean", "spread", "alike"))
        assert [robot.is_unlike for robot in ours.robots] == [robot["is_unlike"] for robot in by_command["robots"]]
    ratio = judged["wheel_radius_ratio"]
    assert [robot.is_unlike for robot in ratio.robots] == [False, False, False, True] and ratio.is_common
    assert all(robot.trend and not robot.trend.is_there for robot in ratio.robots)


def test_effects_of_a_model_file_are_common_too(tmp_path):
    for name in ("ada", "bob"):
        record(tmp_path / name / "runs", 0.02, 3)
    folders = [tmp_path / name / "runs" for name in ("ada", "bob")]
    command("model", "add", "wheel_radius_ratio", folders[0])
    told = [Campaign.from_folder(folder).explain() for folder in folders]
    assert [one.effect for one in told[0].known] == ["wheel_radius_ratio"]
    # Of the folder's own equation, only if all have it.
    for folder in folders:
        shutil.rmtree(folder)
        record(folder, 0.02, 3, bend=0.1)
    for number, folder in enumerate(folders, 1):
        command("model", "add", "--custom", "dtheta = k * v^2", "--name", "my_bend", folder)
        # As other processes get them.
        told = [pickle.loads(pickle.dumps(Campaign.from_folder(folder).explain())) for folder in folders]
        common = fleet.common_effects(told)
        assert ("my_bend" in common) == (number == 2), common
    for folder in folders:
        found = Campaign.from_folder(folder).fit(common)["my_bend"].parameters[0]
        assert abs(found.value - 0.1) < 4 * found.sigma


def test_what_is_no_number_is_left_out():
    judged = fleet.judge({"k": [(0, 1.0, float("nan"), 1.0), (0, 2.0, 1.0, 0.0), (1, None, 1.0, 0.1)]})
    assert [robot.robot for robot in judged["k"].robots] == [1]
