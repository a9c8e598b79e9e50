"""Do other programs read what Beeline writes, and Beeline what they write?

`cargo xtask peers` installs what it needs, and runs it with the place of `beeline`. Each check prints a line. The exit code is 1 if one fails.
"""

import csv
import json
import math
import pathlib
import shutil
import subprocess
import sys
import tempfile

import numpy as np
import yaml
from evo.core import metrics, sync
from evo.tools import file_interface
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore
from wpiutil import DataLogWriter
from wpiutil.log import DoubleArrayLogEntry, DoubleLogEntry

MYSTERY = pathlib.Path(__file__).parents[3] / "examples" / "mystery-robot"
# https://control.ros.org/jazzy/doc/ros2_controllers/diff_drive_controller/doc/userdoc.html
DIFF_DRIVE = {
    "wheel_separation",
    "wheel_separation_multiplier",
    "wheel_radius",
    "left_wheel_radius_multiplier",
    "right_wheel_radius_multiplier",
    "pose_covariance_diagonal",
    "twist_covariance_diagonal",
}

beeline = pathlib.Path(sys.argv[1]).resolve()
folder = pathlib.Path(tempfile.mkdtemp(prefix="beeline-peers-"))
failures = 0


def run(*arguments):
    """What a command of Beeline prints."""
    done = subprocess.run([beeline, *map(str, arguments)], cwd=folder, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"beeline {arguments}: {done.stderr}")
    return done.stdout


def check(what, holds, detail=""):
    global failures
    failures += not holds
    print(f"{'ok  ' if holds else 'FAIL'}  {what}  {detail}")


def speed_growth(campaign):
    """What `explain` finds, which must be all: value and standard error."""
    steps = json.loads(run("explain", campaign, "--format", "json"))["steps"]
    if [step["effect"] for step in steps] != ["speed_growth"]:
        return math.nan, math.nan
    found = steps[0]["parameters"][0]
    return found["value"], found["sigma"]


POSE = ("x_m", "y_m", "heading_rad")


def exported(table):
    """The runs of a campaign from the table that Beeline writes: poses as measured, and then as predicted, by the clock of the wheels."""
    runs = {}
    for row in csv.DictReader(table.splitlines()):
        one = runs.setdefault(row["run"], {"wheels": [], "odometry": [], "poses": []})
        t_s = float(row["t_s"])
        if row["left_rad"]:
            one["wheels"].append((t_s, float(row["left_rad"]), float(row["right_rad"])))
            one["odometry"].append((t_s, *(float(row[f"odometry_{name}"]) for name in POSE)))
        else:
            names = [*POSE, *(f"predicted_{name}" for name in ("t_s", *POSE))]
            one["poses"].append((t_s, *(float(row[name] or "nan") for name in names)))
    return runs


def bag_is_read_by_others(runs):
    wheels = np.array([row[1:] for run in runs.values() for row in run["wheels"]])
    with open(folder / "drive.mcap", "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        messages = [(channel.topic, message) for _, channel, _, message in reader.iter_decoded_messages()]
    by_mcap = np.array([list(message.position) for topic, message in messages if topic == "/joint_states"])
    check("mcap reads our bag", by_mcap.shape == wheels.shape and np.allclose(by_mcap, wheels, atol=1e-6), by_mcap.shape)
    with AnyReader([folder / "drive.mcap"]) as reader:
        read = [
            (connection.topic, reader.deserialize(data, connection.msgtype))
            for connection, _, data in reader.messages()
        ]
    by_rosbags = np.array([message.position for topic, message in read if topic == "/joint_states"])
    check("rosbags reads our bag", by_rosbags.shape == wheels.shape and np.allclose(by_rosbags, wheels, atol=1e-6))
    odometry = np.array([row[1:3] for run in runs.values() for row in run["odometry"]])
    of_bag = np.array(
        [(m.pose.pose.position.x, m.pose.pose.position.y) for topic, m in read if topic == "/odom"]
    )
    check("and its odometry is that of the table", np.allclose(of_bag, odometry, atol=1e-6))
    predicted = np.array([row[5:7] for run in runs.values() for row in run["poses"]])
    of_bag = [one.pose.position for topic, m in read if topic == "/predicted" for one in m.poses]
    check("and the predicted paths too", np.allclose([(at.x, at.y) for at in of_bag], predicted, atol=1e-6))
    apart = np.array([np.subtract(row[1:3], row[5:7]) for run in runs.values() for row in run["poses"]])
    of_bag = np.array([(m.vector.x, m.vector.y) for topic, m in read if topic == "/residual"])
    check("and residuals are as long as poses are apart", np.allclose(np.hypot(*of_bag.T), np.hypot(*apart.T), atol=1e-6))


def a_recorded_bag_has_what_the_robot_tells_of_itself():
    run("record", "recorded", "arc", "1m", "90deg", "--mcap", "recorded.mcap")
    with open(next((folder / "recorded" / "runs").glob("*.csv"))) as file:
        rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#")) if row["bus_v"]]
    duty = np.array([(float(row["left_duty"]), float(row["right_duty"])) for row in rows])
    volts = np.array([float(row["bus_v"]) for row in rows])
    with open(folder / "recorded.mcap", "rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        by_mcap = [(channel.topic, message) for _, channel, _, message in reader.iter_decoded_messages()]
    with AnyReader([folder / "recorded.mcap"]) as reader:
        by_rosbags = [(c.topic, reader.deserialize(data, c.msgtype)) for c, _, data in reader.messages()]
    for name, read in (("mcap", by_mcap), ("rosbags", by_rosbags)):
        told = np.array([[one.values[0] for one in m.interface_values] for topic, m in read if topic == "/dynamic_joint_states"])
        check(f"{name} reads the duty of a recorded bag", told.shape == duty.shape and np.allclose(told, duty, atol=1e-4), told.shape)
        told = np.array([m.voltage for topic, m in read if topic == "/battery_state"])
        check(f"{name} reads its voltage", told.shape == volts.shape and np.allclose(told, volts, atol=1e-3), told.shape)


def bags_of_others_are_read(runs):
    expected, sigma = speed_growth(MYSTERY)
    for store in (Stores.ROS2_HUMBLE, Stores.ROS2_JAZZY):
        for plugin in (StoragePlugin.MCAP, StoragePlugin.SQLITE3):
            name = f"{store.value}_{plugin.name}".lower()
            write(folder / name, get_typestore(store), plugin, runs)
            sheet = ("--wheel-radius", "36mm", "--track-width", "37.2cm")
            told = json.loads(run("import", folder / name, "-o", f"of_{name}", "--json", *sheet))
            value, _ = speed_growth(f"of_{name}")
            holds = len(told["runs"]) == 20 and abs(value - expected) < sigma
            columns = next(csv.reader(open(next((folder / f"of_{name}" / "runs").glob("*spin_left*.csv")))))
            holds = holds and {"gyro_z_rad_s", "bus_v"} <= set(columns)
            check(f"we read a bag of rosbags, {name}", holds, f"{value:.5f}, not {expected:.5f} ± {sigma:.5f}")


def write(place, store, plugin, runs):
    kinds = store.types
    joint_state, pose_stamped = kinds["sensor_msgs/msg/JointState"], kinds["geometry_msgs/msg/PoseStamped"]
    time, head = kinds["builtin_interfaces/msg/Time"], kinds["std_msgs/msg/Header"]
    pose, point = kinds["geometry_msgs/msg/Pose"], kinds["geometry_msgs/msg/Point"]
    quaternion, vector = kinds["geometry_msgs/msg/Quaternion"], kinds["geometry_msgs/msg/Vector3"]
    imu, battery = kinds["sensor_msgs/msg/Imu"], kinds["sensor_msgs/msg/BatteryState"]
    with Writer(place, version=9, storage_plugin=plugin) as bag:
        joints = bag.add_connection("/joints", joint_state.__msgtype__, typestore=store)
        poses = bag.add_connection("/vicon", pose_stamped.__msgtype__, typestore=store)
        rates = bag.add_connection("/imu", imu.__msgtype__, typestore=store)
        volts = bag.add_connection("/battery", battery.__msgtype__, typestore=store)
        for number, one in enumerate(runs.values()):
            start_ns = 1_700_000_000_000_000_000 + number * 100_000_000_000

            def stamped(t_s):
                ns = start_ns + round(t_s * 1e9)
                return ns, head(time(ns // 10**9, ns % 10**9), "map")

            for t_s, left, right in one["wheels"]:
                ns, header = stamped(t_s)
                numbers = np.array([left, right]), np.array([]), np.array([])
                message = joint_state(header, ["left_wheel", "right_wheel"], *numbers)
                bag.write(joints, ns, store.serialize_cdr(message, joint_state.__msgtype__))
                numbers = [12.25, 20.0, *[math.nan] * 5]
                message = battery(header, *numbers, 0, 0, 0, True, np.array([], np.float32), np.array([], np.float32), "", "")
                bag.write(volts, ns, store.serialize_cdr(message, battery.__msgtype__))
            for before, after in zip(one["odometry"], one["odometry"][1:]):
                ns, header = stamped((before[0] + after[0]) / 2)
                rate = vector(0.0, 0.0, (after[3] - before[3]) / (after[0] - before[0]))
                still, none = vector(0.0, 0.0, 9.8), np.zeros(9)
                message = imu(header, quaternion(0.0, 0.0, 0.0, 1.0), none, rate, none, still, none)
                bag.write(rates, ns, store.serialize_cdr(message, imu.__msgtype__))
            for t_s, x, y, heading, *_ in one["poses"]:
                ns, header = stamped(t_s)
                turned = quaternion(0.0, 0.0, math.sin(heading / 2), math.cos(heading / 2))
                message = pose_stamped(header, pose(point(x, y, 0.0), turned))
                bag.write(poses, ns, store.serialize_cdr(message, pose_stamped.__msgtype__))


def a_data_log_of_wpilib_is_read(runs):
    """As a robot program logs: each wheel when it changes, and poses of a camera."""
    expected, sigma = speed_growth(MYSTERY)
    log = DataLogWriter(str(folder / "drive.wpilog"))
    wheels = [DoubleLogEntry(log, f"/drive/{side}") for side in ("left", "right")]
    poses = DoubleArrayLogEntry(log, "/camera/pose")
    for number, one in enumerate(runs.values()):
        start_us = 1_000_000 + number * 100_000_000
        records = [(t_s, wheels[side], angles[side]) for t_s, *angles in one["wheels"] for side in (0, 1)]
        records += [(t_s, poses, pose) for t_s, *pose in (row[:4] for row in one["poses"])]
        for t_s, entry, value in sorted(records, key=lambda record: record[0]):
            at_us = start_us + round(t_s * 1e6)
            (entry.update if entry in wheels else entry.append)(value, at_us)
    log.flush()
    log.stop()
    columns = {"left_rad": "/drive/left", "right_rad": "/drive/right"}
    columns |= {name: f"/camera/pose[{k}]" for k, name in enumerate(("x_m", "y_m", "heading_rad"))}
    mapping = ",".join(f"{name}={column}" for name, column in columns.items())
    sheet = ("--wheel-radius", "36mm", "--track-width", "37.2cm")
    run("import", "drive.wpilog", "-o", "of_wpilog", "--map", mapping, *sheet)
    value, _ = speed_growth("of_wpilog")
    check("we read a data log of WPILib", abs(value - expected) < sigma, f"{value:.5f}, not {expected:.5f} ± {sigma:.5f}")


def trajectories_are_read_by_evo(runs):
    worst = 0.0
    for name, one in runs.items():
        files = [folder / "tracks" / f"{name}_{what}.tum" for what in ("measured", "odometry", "predicted")]
        measured, odometry, predicted = map(file_interface.read_tum_trajectory_file, map(str, files))
        of_table = np.array([row[5:7] for row in one["poses"]])
        worst = max(worst, np.abs(predicted.positions_xyz[:, :2] - of_table).max())
        measured, odometry = sync.associate_trajectories(measured, odometry, max_diff=0.002)
        error = metrics.APE(metrics.PoseRelation.translation_part)
        error.process_data((measured, odometry))
        by_evo = error.get_statistic(metrics.StatisticsType.rmse)
        # The same from the table.
        at = {round(row[0], 3): row for row in one["odometry"]}
        pairs = [(row, at[round(row[0], 3)]) for row in one["poses"] if round(row[0], 3) in at]
        squares = [(a[1] - b[1]) ** 2 + (a[2] - b[2]) ** 2 for a, b in pairs]
        worst = max(worst, abs(by_evo - math.sqrt(sum(squares) / len(squares))))
        if len(pairs) != measured.num_poses:
            worst = math.nan
    check("evo computes the error of our table from our trajectories", worst < 1e-6, f"{worst:.1e} m")


def parameters_are_those_of_the_controller(runs):
    told = yaml.safe_load(run("export", MYSTERY, "--to", "ros2"))["diff_drive_controller"]["ros__parameters"]
    check("PyYAML reads our parameters, and each is documented", set(told) == DIFF_DRIVE)
    turtlebot3 = yaml.safe_load(run("export", MYSTERY, "--to", "turtlebot3"))["turtlebot3_node"]["ros__parameters"]
    check("and those of TurtleBot3", set(turtlebot3["wheels"]) == {"radius", "separation"})
    # Odometry as the controller computes it, from the angles.
    radius = told["wheel_radius"]
    left_m = radius * told["left_wheel_radius_multiplier"]
    right_m = radius * told["right_wheel_radius_multiplier"]
    width_m = told["wheel_separation"] * told["wheel_separation_multiplier"]
    worst = 0.0
    for one in runs.values():
        _, x, y, heading = one["odometry"][0]
        _, before_left, before_right = one["wheels"][0]
        for (_, left, right), (_, our_x, our_y, _) in zip(one["wheels"], one["odometry"]):
            rolled_left, rolled_right = left_m * (left - before_left), right_m * (right - before_right)
            before_left, before_right = left, right
            travel, turn = (rolled_left + rolled_right) / 2, (rolled_right - rolled_left) / width_m
            if abs(turn) < 1e-6:
                x += travel * math.cos(heading + turn / 2)
                y += travel * math.sin(heading + turn / 2)
            else:
                x += travel / turn * (math.sin(heading + turn) - math.sin(heading))
                y -= travel / turn * (math.cos(heading + turn) - math.cos(heading))
            heading += turn
            worst = max(worst, math.hypot(x - our_x, y - our_y))
    check("an odometry of these parameters is ours", worst < 1e-4, f"{worst:.1e} m")


def odometry(wheels, parameters):
    """Poses as diff_drive_controller computes them from angles, at every sample, from the origin."""
    t_s, left, right = wheels
    left_m = parameters["wheel_radius"] * parameters["left_wheel_radius_multiplier"]
    right_m = parameters["wheel_radius"] * parameters["right_wheel_radius_multiplier"]
    width_m = parameters["wheel_separation"] * parameters["wheel_separation_multiplier"]
    rolled = left_m * np.diff(left), right_m * np.diff(right)
    travel, turn = (rolled[0] + rolled[1]) / 2, (rolled[1] - rolled[0]) / width_m
    heading = np.concatenate([[0], np.cumsum(turn)])
    # Exact along the arc: the chord is shorter than the arc by sin(h) / h of half the turn.
    chord = travel * np.sinc(turn / 2 / math.pi)
    middle = heading[:-1] + turn / 2
    return t_s, *(np.concatenate([[0], np.cumsum(chord * of(middle))]) for of in (np.cos, np.sin))


def squares(x, y, measured_x, measured_y):
    """Squared distances to the measured positions, once a path is laid on them as well as turning and shifting it can."""
    # A pose that was measured before the wheels were is not predicted.
    seen = np.isfinite(x)
    path, aim = (x + 1j * y)[seen], (measured_x + 1j * measured_y)[seen]
    path, aim = path - path.mean(), aim - aim.mean()
    # A robot that rests turns nowhere.
    turn = np.vdot(path, aim) or 1.0
    return np.abs(aim - path * turn / abs(turn)) ** 2


def parameters_serve_runs_that_were_held_out(example, every):
    """An odometry by the exported parameters, on runs that were held out: as good as our own model of the same numbers?"""
    place = folder / f"held_out_{example.name}"
    shutil.copytree(example, place)
    robot = place / "robot.toml"
    text = robot.read_text()
    for name in sorted(file.stem for file in (place / "runs").glob("*.csv"))[::every]:
        line = f'name = "{name}"\n'
        if line in text:
            text = text.replace(line, f"{line}held_out = true\n")
        else:
            text += f"\n[[run]]\n{line}held_out = true\n"
    robot.write_text(text)
    told = yaml.safe_load(run("export", place, "--to", "ros2"))["diff_drive_controller"]["ros__parameters"]
    nominal = {**told, **{name: 1.0 for name in told if name.endswith("multiplier")}}
    (place / "model.toml").unlink(missing_ok=True)
    for effect in ("wheel_radius_ratio", "wheel_radius_scale", "track_width"):
        run("model", "add", effect, place)
    held_out = {one["name"] for one in json.loads(run("compare", place, "--json"))["comparison"]["runs"] if one["held_out"]}
    sums = {"nominal": [], "parameters": [], "ours": []}
    for name, one in exported(run("export", place, "--to", "csv")).items():
        if name not in held_out:
            continue
        wheels = np.array(one["wheels"]).T
        measured_x, measured_y, _, t_s, *ours = np.array([row[1:] for row in one["poses"]]).T
        for key, numbers in (("nominal", nominal), ("parameters", told)):
            at_s, x, y = odometry(wheels, numbers)
            sums[key].append(squares(*(np.interp(t_s, at_s, values) for values in (x, y)), measured_x, measured_y))
        sums["ours"].append(squares(*ours[:2], measured_x, measured_y))
    before, theirs, ours = (1e3 * math.sqrt(np.concatenate(one).mean()) for one in sums.values())
    share = (before - theirs) / (before - ours)
    detail = f"{len(sums['ours'])} runs: {before:.2f} mm, {theirs:.2f} mm by the parameters, {ours:.2f} mm by our model"
    check(f"parameters reduce the held-out error of {example.name} as our model does", abs(share - 1) < 0.01 and ours < before, detail)


run("export", MYSTERY, "--to", "mcap", "-o", "drive.mcap")
run("export", MYSTERY, "--to", "tum", "-o", "tracks")
table = exported(run("export", MYSTERY, "--to", "csv"))
bag_is_read_by_others(table)
a_recorded_bag_has_what_the_robot_tells_of_itself()
trajectories_are_read_by_evo(table)
parameters_are_those_of_the_controller(table)
parameters_serve_runs_that_were_held_out(MYSTERY, 3)
parameters_serve_runs_that_were_held_out(MYSTERY.parent / "optiodom", 3)
# The robot rests in one run, which is none for an import.
bags_of_others_are_read(table)
a_data_log_of_wpilib_is_read(table)
sys.exit(min(failures, 1))
