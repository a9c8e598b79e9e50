"""Fits wheel radii and track width to whole tracks, start poses free: SciPy's least_squares.

Reads wheel travels and poses of all runs from the file named on the command line, prints the seconds
taken, the three parameters and the number of function evaluations.
"""

import sys
import time

import numpy as np
from scipy.optimize import least_squares

table = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1)
radius_m, track_m = float(sys.argv[2]), float(sys.argv[3])
runs = [table[table[:, 0] == run, 1:] for run in np.unique(table[:, 0])]
sigma_m, sigma_rad = 1e-3, 2e-3


def residuals(p):
    rho, scale, delta = p[:3]
    parts = []
    for k, run in enumerate(runs):
        x0, y0, heading0 = p[3 + 3 * k : 6 + 3 * k]
        left = np.diff(run[:, 0]) * radius_m * (1 - rho / 2) * (1 + scale)
        right = np.diff(run[:, 1]) * radius_m * (1 + rho / 2) * (1 + scale)
        turn = (right - left) / (track_m * (1 + delta))
        heading = heading0 + np.concatenate([[0.0], np.cumsum(turn)])
        middle = (heading[1:] + heading[:-1]) / 2
        travel = (left + right) / 2 * np.sinc(turn / 2 / np.pi)
        x = x0 + np.concatenate([[0.0], np.cumsum(travel * np.cos(middle))])
        y = y0 + np.concatenate([[0.0], np.cumsum(travel * np.sin(middle))])
        parts += [(run[:, 2] - x) / sigma_m, (run[:, 3] - y) / sigma_m, (run[:, 4] - heading) / sigma_rad]
    return np.concatenate(parts)


start = np.concatenate([[0.0, 0.0, 0.0]] + [run[0, 2:5] for run in runs])
began = time.perf_counter()
found = least_squares(residuals, start, x_scale="jac")
print(time.perf_counter() - began, *found.x[:3], found.nfev)
