"""Motor constants as others identify them, from the files that bench_identification writes.

Each file of the folder on the command line has the rows run, t [s], travel [m], voltage summed over time [V s] of one wheel;
each run begins at rest. Prints a line for each file:

    NAME  kS kV kA  kS+ kS- kV kA delay

First the form of WPILib's SysId: ordinary least squares of dv/dt = alpha v + beta V + gamma sgn(v), so that
kS = -gamma/beta, kV = -alpha/beta, kA = 1/beta; speed and acceleration are central differences over 60 ms, as tuners take them
from counts, and samples slower than a twentieth of the fastest are left out. Then output error by SciPy's least_squares: the
measured voltage drives kS, kV, kA and a delay, and travel is compared; where each run begins is free.
"""

import sys
from pathlib import Path

import numpy as np
from scipy.optimize import least_squares

HALF_S = 0.03
SUBSTEPS = 2


def runs_of(path):
    table = np.loadtxt(path, delimiter=",", ndmin=2)
    return [table[table[:, 0] == run, 1:] for run in np.unique(table[:, 0])]


def differences(run):
    t, x, vs = run.T
    middle = t[(t >= t[0] + 2 * HALF_S) & (t <= t[-1] - 2 * HALF_S)]
    at = lambda values, shift: np.interp(middle + shift, t, values)
    speed = lambda shift: (at(x, shift + HALF_S) - at(x, shift - HALF_S)) / (2 * HALF_S)
    acceleration = (speed(HALF_S) - speed(-HALF_S)) / (2 * HALF_S)
    volts = (at(vs, HALF_S) - at(vs, -HALF_S)) / (2 * HALF_S)
    return np.column_stack([speed(0.0), volts, acceleration])


def regression(runs):
    rows = np.vstack([differences(run) for run in runs])
    rows = rows[np.abs(rows[:, 0]) > 0.05 * np.abs(rows[:, 0]).max()]
    speed, volts, acceleration = rows.T
    terms = np.column_stack([speed, volts, np.sign(speed)])
    alpha, beta, gamma = np.linalg.lstsq(terms, acceleration, rcond=None)[0]
    return -gamma / beta, -alpha / beta, 1.0 / beta


def simulate(constants, runs, longest):
    """Travel of all runs at their samples; runs are padded to the longest one."""
    ks_forward, ks_backward, kv, ka, delay = constants
    t = [run[:, 0] for run in runs]
    v = np.zeros(len(runs))
    x = np.zeros(len(runs))
    travel = np.zeros((longest, len(runs)))
    fine = [np.interp(np.arange((len(one) - 1) * SUBSTEPS + 1) / SUBSTEPS, np.arange(len(one)), one) for one in t]
    volts = np.zeros(((longest - 1) * SUBSTEPS, len(runs)))
    step = np.full_like(volts, 1e-3)
    for index, run in enumerate(runs):
        summed = np.interp(fine[index] - delay, run[:, 0], run[:, 2])
        count = len(summed) - 1
        step[:count, index] = np.diff(fine[index])
        volts[:count, index] = np.diff(summed) / step[:count, index]
    for k in range(len(volts)):
        h = step[k]
        # Implicit in speed and friction.
        inertia = 1.0 + h * kv / ka
        free = (v + h * volts[k] / ka) / inertia
        friction = np.where(free > 0.0, ks_forward, ks_backward) * h / ka / inertia
        after = np.sign(free) * np.maximum(np.abs(free) - friction, 0.0)
        x = x + 0.5 * h * (v + after)
        v = after
        if (k + 1) % SUBSTEPS == 0:
            travel[(k + 1) // SUBSTEPS] = x
    return travel


def output_error(runs, start):
    longest = max(len(run) for run in runs)

    def residuals(constants):
        travel = simulate(constants, runs, longest)
        parts = []
        for index, run in enumerate(runs):
            off = run[:, 1] - run[0, 1] - travel[: len(run), index]
            parts.append((off - off.mean()) * 1e3)
        return np.concatenate(parts)

    ks, kv, ka = (max(value, low) for value, low in zip(start, (0.05, 1.0, 0.05)))
    begin = np.array([ks, ks, kv, min(max(ka, 0.005 * kv), kv), 0.003])
    low = [0.0, 0.0, 1e-3, 1e-4 * kv, 0.0]
    high = [20.0, 20.0, 1e4, 1e3, 0.05]
    return least_squares(residuals, begin, bounds=(low, high), x_scale=[0.1, 0.1, 0.1 * kv, 0.1 * begin[3], 1e-3], max_nfev=40).x


for path in sorted(Path(sys.argv[1]).glob("*.csv")):
    runs = runs_of(path)
    first = regression(runs)
    print(path.stem, *first, *output_error(runs, first), flush=True)
