# SPDX-License-Identifier: LGPL-2.1-or-later
"""Runs scenes with the stroma command and reads what they recorded; writes tables."""
import csv
import gzip
import json
import os
import platform
import subprocess
import tempfile

import numpy as np

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
BESIDE = os.path.join(ROOT, "..", "shared", "data")  # shared data beside the checkout


def default_data():
    """STROMA_SHARED_DATA, else the shared data beside the checkout."""
    return os.environ.get("STROMA_SHARED_DATA") or BESIDE


class Stroma:
    """The command at `path`; scenes are named from the project's root. `data`: the folder of real measurements and meshes,
    which need not exist."""

    def __init__(self, path, data):
        self.path = os.path.abspath(path)
        self.data = os.path.abspath(data)

    def shared_file(self, *parts):
        """Path of a file of the shared data, or None when it is absent."""
        path = os.path.join(self.data, *parts)
        return path if os.path.exists(path) else None

    def run(self, scene, settings=(), steps=None, until=None, every=1):
        """A run: dict with `summary` (the command's JSON), `message` (standard error), `code`, and `frames`: for each
        state, by its path, positions of shape (instants, nodes, 3) [m]."""
        with tempfile.TemporaryDirectory() as folder:
            command = [self.path, "run", os.path.join(ROOT, scene), "--quiet", "--json", "--record", folder,
                       "--record-every", str(every)]
            command += ["-n", str(steps)] if until is None else ["--until", str(until)]
            for setting in settings:
                command += ["--set", setting]
            result = subprocess.run(command, capture_output=True, text=True)
            frames = {name[:-len(".state.gz")]: read_state(os.path.join(folder, name))
                      for name in os.listdir(folder) if name.endswith(".state.gz")}
        summary = json.loads(result.stdout) if result.stdout.strip().startswith("{") else {}
        return {"summary": summary, "message": result.stderr.strip(), "code": result.returncode, "frames": frames}


def read_state(path):
    with gzip.open(path, "rt") as file:
        rows = [line.split("=")[1] for line in file if line.strip().startswith("X=")]
    return np.array([np.array(row.split(), float).reshape(-1, 3) for row in rows])


def machine():
    """A line on the machine: processor, cores, load."""
    model = platform.processor()
    with open("/proc/cpuinfo") as file:
        for line in file:
            if line.startswith("model name"):
                model = line.split(":")[1].strip()
                break
    return f"{model}, {os.cpu_count()} cores, load {os.getloadavg()[0]:.1f}"


def write_csv(path, header, rows):
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(header)
        writer.writerows(rows)


def markdown(header, rows):
    """A table; numbers as they are given in text."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    lines += ["| " + " | ".join(str(value) for value in row) + " |" for row in rows]
    return "\n".join(lines) + "\n"
