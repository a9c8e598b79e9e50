"""A fleet on many machines: the Python package under Ray.

    pip install ray ./python
    python examples/fleet_ray.py FOLDER [--workers 2] [--json fleet.json]

FOLDER holds campaign folders at any depth, and every machine sees it at the same place. Each campaign is read twice: to be explained, and to
be fitted with what its kind has. What is judged is a few numbers a campaign, here.
"""

import argparse
import dataclasses
import json
import pathlib
import re
import time
from collections import defaultdict
from datetime import date

import ray

import beeline
from beeline import fleet


@ray.remote
def explained(folder):
    """What a campaign shows, and what tells its robot from others; or why it cannot be used."""
    began = time.process_time()
    try:
        campaign = beeline.Campaign.from_folder(folder)
        explanation = campaign.explain()
    except beeline.BeelineError as error:
        return folder, None, None, str(error), time.process_time() - began
    return folder, campaign.robot, explanation, None, time.process_time() - began


@ray.remote
def fitted(folder, effects):
    """The values of these effects in a campaign: by effect and parameter, each with its standard error."""
    began = time.process_time()
    fit = beeline.Campaign.from_folder(folder).fit(effects)
    values = {(one.effect, p.name): (p.value, p.sigma) for one in fit.effects for p in one.parameters}
    return folder, values, time.process_time() - began


def day(folder):
    """The day of a date in the folder's name, since 1970."""
    found = re.search(r"(?<!\d)(\d{4})-(\d\d)-(\d\d)(?!\d)", pathlib.Path(folder).name)
    return float((date(*map(int, found.groups())) - date(1970, 1, 1)).days) if found else None


def limited(task, arguments, at_once):
    """Results as they come, with so many tasks at once: ten thousand robots must not be ten thousand tasks in a queue."""
    waiting, arguments = [], iter(arguments)
    while True:
        for one in arguments:
            waiting.append(task.remote(*one))
            if len(waiting) >= at_once:
                break
        if not waiting:
            return
        done, waiting = ray.wait(waiting)
        yield from ray.get(done)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("folder")
    parser.add_argument("--workers", type=int, help="on this machine; without it, the cluster that RAY_ADDRESS names, or all cores")
    parser.add_argument("--json", help="where to write what is found")
    options = parser.parse_args()
    # One core a campaign: campaigns are many, so none needs several.
    threads = {"env_vars": {"RAYON_NUM_THREADS": "1"}}
    ray.init(num_cpus=options.workers, runtime_env=threads, log_to_driver=False, logging_level="error")
    at_once = 4 * int(ray.cluster_resources()["CPU"])
    # Workers are started before anything is timed.
    ray.get([explained.remote("/nowhere") for _ in range(at_once)])

    folders = sorted(str(file.parent) for file in pathlib.Path(options.folder).resolve().rglob("robot.toml"))
    began = time.perf_counter()
    kinds, cpu_s = defaultdict(list), 0.0
    for folder, robot, explanation, error, took_s in limited(explained, ((one,) for one in folders), at_once):
        cpu_s += took_s
        if error:
            print(f"left out: {error}")
            continue
        kinds[dataclasses.replace(robot, name="", position_sigma_m=None, heading_sigma_rad=None)].append((folder, robot.name, explanation))

    asked, robots = {}, {}
    for kind, members in enumerate(kinds.values()):
        # As campaigns come in any order, and numbers of robots must not depend on it.
        members.sort(key=lambda one: one[0])
        robots[kind] = sorted({name for _, name, _ in members})
        effects = fleet.common_effects(explanation for *_, explanation in members)
        names = {folder: name for folder, name, _ in members}
        results = sorted(limited(fitted, ((folder, effects) for folder in names), at_once), key=lambda one: one[0])
        for folder, values, took_s in results:
            cpu_s += took_s
            for (effect, parameter), value in values.items():
                entry = (robots[kind].index(names[folder]), day(folder), *value)
                asked.setdefault((kind, effect, parameter), []).append(entry)
    took_s = time.perf_counter() - began

    findings = []
    for (kind, effect, parameter), judged in fleet.judge(asked).items():
        for one in judged.robots:
            name = robots[kind][one.robot]
            if one.trend and one.trend.is_there:
                findings.append({"what": "changes", "robot": name, "effect": effect, "per_day": one.trend.per_day})
            elif one.is_unlike:
                findings.append({"what": "unlike", "robot": name, "effect": effect, "value": one.mean})
        if judged.is_common:
            findings.append({"what": "common", "robot": None, "effect": effect, "value": judged.mean})
    for finding in findings:
        print(*(f"{key}={value}" for key, value in finding.items() if value is not None))
    used = int(ray.cluster_resources()["CPU"])
    count = max(len(folders), 1)
    print(f"{len(folders)} campaigns on {used} workers: {took_s:.1f} s, {cpu_s / count:.2f} s of processor time each")
    if options.json:
        figures = {"campaigns": len(folders), "workers": used, "took_s": took_s, "cpu_s": cpu_s}
        pathlib.Path(options.json).write_text(json.dumps({"findings": findings, **figures}, indent=1))


if __name__ == "__main__":
    main()
