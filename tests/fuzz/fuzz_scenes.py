#!/usr/bin/env python3
# SPDX-License-Identifier: LGPL-2.1-or-later
"""Damages example scenes and their meshes, and runs what comes out: `stroma check`, then three steps.

Whatever the damage is, the program must end by itself with one of its exit codes and a sentence: no crash, no hang, no
memory beyond what the scene needs, and no number that is not finite in any file it writes. Each mutant is made from the
seed and its number alone, so that `--seed S --first N --count 1 --keep DIR` makes it again.

Example: tests/fuzz/fuzz_scenes.py --stroma build/release/bin/stroma --seed 1 --count 500 --jobs 2"""

import argparse
import concurrent.futures
import gzip
import math
import os
import random
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import time
from collections import Counter
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent.parent
NUMBER = re.compile(rb"[-+]?\d+(?:\.\d*)?(?:[eE][-+]?\d+)?")
ATTRIBUTE = re.compile(rb'[\w:]+\s*=\s*"[^"]*"')
ELEMENT = re.compile(rb"<[^<>]*/>")
WEIRD = [b"0", b"-0", b"-1", b"1", b"2", b"3", b"1e-320", b"1e-30", b"1e-9", b"0.4999999", b"0.5", b"1e9", b"1e30", b"1e308",
         b"-1e308", b"1e400", b"nan", b"inf", b"-inf", b"255", b"65536", b"99999999", b"2147483647", b"-2147483648",
         b"4294967296", b"9223372036854775807", b"18446744073709551615", b"", b"x", b"0x10", b"1-3", b"0-99999999"]
EXIT_CODES = {"check": {0, 1, 2}, "run": {0, 2, 3, 4}}


# ---- damage ----

def cut_out(data, chance):
    """A random piece of data: short ones are likelier."""
    first = chance.randrange(len(data) + 1)
    return first, min(len(data), first + int(2 ** chance.uniform(0, 10)))


def change_number(data, chance, pattern=NUMBER):
    found = list(pattern.finditer(data))
    if not found:
        return data
    first, last = chance.choice(found).span()
    if chance.random() < 0.3:
        number = b"%d" % int(2 ** chance.uniform(0, 40))
    elif chance.random() < 0.3:
        number = data[first:last] + chance.choice([b"0", b"9", b"e3", b"e-3", b".5", b"e200"])
    else:
        number = chance.choice(WEIRD)
    return data[:first] + number + data[last:]


def damage_bytes(data, chance):
    """One of the damages that any file may have."""
    first, last = cut_out(data, chance)
    kind = chance.randrange(6)
    if kind == 0:  # some bytes
        copy = bytearray(data)
        for _ in range(chance.randrange(1, 8)):
            if copy:
                copy[chance.randrange(len(copy))] = chance.randrange(256)
        return bytes(copy)
    if kind == 1 and data:  # a bit
        at = chance.randrange(len(data))
        return data[:at] + bytes([data[at] ^ 1 << chance.randrange(8)]) + data[at + 1:]
    if kind == 2:
        return data[:first]
    if kind == 3:
        return data[:first] + data[last:]
    if kind == 4:
        return data[:last] + data[first:]
    other, end = cut_out(data, chance)
    return data[:first] + data[other:end] + data[last:]


def damage_lines(data, chance):
    """Lines of a mesh: left out, doubled, changed places, or with another number."""
    lines = data.split(b"\n")
    one, other = chance.randrange(len(lines)), chance.randrange(len(lines))
    kind = chance.randrange(4)
    if kind == 0:
        del lines[one]
    elif kind == 1:
        lines.insert(one, lines[other])
    elif kind == 2:
        lines[one], lines[other] = lines[other], lines[one]
    else:
        # counts are in the lines with keywords and in those after them
        near = [n for n, line in enumerate(lines) if re.match(rb"[$A-Z]", line)] or [one]
        one = min(len(lines) - 1, chance.choice(near) + chance.randrange(2))
        lines[one] = change_number(lines[one], chance)
    return b"\n".join(lines)


def replace_some(data, chance, pattern, make):
    found = list(pattern.finditer(data))
    if not found:
        return data
    chosen, other = chance.choice(found), chance.choice(found)
    return data[:chosen.start()] + make(chosen.group(), other.group()) + data[chosen.end():]


def damage_scene(data, chance):
    kind = chance.randrange(8)
    if kind < 4:  # another number in an attribute
        return replace_some(data, chance, ATTRIBUTE, lambda text, _: change_number(text, chance))
    if kind == 4:  # an attribute less, or that of another element
        return replace_some(data, chance, ATTRIBUTE, lambda _, other: chance.choice([b"", other]))
    if kind == 5:  # an element less, twice, or another one
        return replace_some(data, chance, ELEMENT, lambda text, other: chance.choice([b"", text + text, other]))
    if kind == 6:
        return replace_some(data, chance, ATTRIBUTE, lambda text, _: damage_bytes(text, chance))
    return damage_bytes(data, chance)


def damage_mesh(data, chance):
    return chance.choice([damage_bytes, damage_lines, damage_lines, change_number])(data, chance)


# ---- what a run has written ----

def numbers_of_vtu(data):
    """The real numbers of a .vtu file of ours: arrays lie raw behind the XML, each after its length. Those of cells are
    left out: cells without a value are NaN there by intention."""
    start = data.index(b"_", data.index(b'<AppendedData encoding="raw"')) + 1
    head = re.sub(rb"<CellData.*?</CellData>", b"", data[:start], flags=re.S)
    arrays = re.findall(rb'<DataArray type="Float64"[^>]*offset="(\d+)"', head)
    if b'Name="Points"' not in head or not arrays or b'header_type="UInt32"' not in head:
        raise ValueError("a .vtu file is not written as this script reads it")
    for offset in arrays:
        at = start + int(offset)
        size = struct.unpack("<I", data[at:at + 4])[0]
        yield from struct.unpack(f"<{size // 8}d", data[at + 4:at + 4 + size])


def numbers_of_checkpoint(data):
    head, at = data[:data.index(b"\nend ") + 1], data.index(b"\n", data.index(b"\nend ") + 1) + 1
    for kind, count in re.findall(rb"^value (\w) (\d+) ", head, flags=re.M):
        size = int(count) * (1 if kind == b"t" else 8)
        if kind == b"r":
            yield from struct.unpack(f"<{int(count)}d", data[at:at + size])
        at += size


def not_finite(path):
    """Whether a written file has a number that is not finite."""
    data = path.read_bytes()
    if path.suffix == ".gz":
        data = gzip.decompress(data)
    if path.suffix == ".vtu":
        return any(not math.isfinite(value) for value in numbers_of_vtu(data))
    if path.suffix == ".checkpoint":
        return any(not math.isfinite(value) for value in numbers_of_checkpoint(data))
    return re.search(rb"(?<![\w.])[-+]?(nan|inf)(inity)?(?![\w.])", data, flags=re.I) is not None


# ---- runs ----

class Trial:
    def __init__(self, arguments):
        self.stroma, self.seed = arguments.stroma.resolve(), arguments.seed
        self.seconds, self.megabytes, self.keep = arguments.seconds, arguments.memory, arguments.keep
        self.scenes = sorted((TREE / "scenes" / "examples").glob(f"{arguments.scene}.xml"))

    def mutant(self, number, folder):
        """Makes mutant `number` in a folder; the scene's path there and what was damaged."""
        chance = random.Random(f"{self.seed}:{number}")
        shutil.copytree(TREE / "scenes" / "examples", folder / "examples")
        shutil.copytree(TREE / "scenes" / "meshes", folder / "meshes")
        scene = folder / "examples" / chance.choice(self.scenes).name
        meshes = re.findall(r"\.\./meshes/([\w.]+)", scene.read_text(encoding="utf-8"))
        damaged = []
        if meshes and chance.random() < 0.6:
            mesh = folder / "meshes" / chance.choice(meshes)
            self.damage(mesh, damage_mesh, chance)
            damaged.append(mesh.name)
        if not damaged or chance.random() < 0.2:
            self.damage(scene, damage_scene, chance)
            damaged.append(scene.name)
        return scene, " and ".join([scene.name] + [name for name in damaged if name != scene.name])

    @staticmethod
    def damage(path, damage, chance):
        data = path.read_bytes()
        for _ in range(chance.choice([1, 1, 1, 2, 4])):
            data = damage(data, chance)
        path.write_bytes(data)

    def run(self, command, arguments, folder):
        """What is wrong with how the command ended, or None, and its exit code."""
        with open(folder / f"{command}.printed", "w+b") as printed:
            limits = f'ulimit -c 0; ulimit -f {1 << 21}; ulimit -d {self.megabytes << 11}; exec "$@"'
            process = subprocess.Popen(["sh", "-c", limits, "sh", self.stroma, command, *arguments], cwd=folder,
                                       stdin=subprocess.DEVNULL, stdout=printed, stderr=printed)
        code, megabytes = self.end_of(process)
        said = (folder / f"{command}.printed").read_bytes()
        end = said[-300:].decode(errors="replace")
        if code is None:
            return f"hang: no end within {self.seconds} s", None
        if code not in EXIT_CODES[command]:
            return f"crash: code {code}: {end}", code
        if code == 2 and b"error" not in said:
            return f"silent: code {code} without a sentence: {end}", code
        if megabytes > self.megabytes:
            return f"memory: {megabytes:.0f} MB: {end}", code
        return None, code

    def end_of(self, process):
        """The exit code, None after a hang, and the memory that the process and its children had at most [MB]."""
        until = time.monotonic() + self.seconds
        while True:
            pid, status, used = os.wait4(process.pid, os.WNOHANG)
            if pid:
                process.returncode = os.waitstatus_to_exitcode(status)
                return process.returncode, used.ru_maxrss / 1024
            if time.monotonic() > until:
                process.kill()
                process.wait()
                return None, 0
            time.sleep(0.005)

    def problems(self, number, folder):
        """Problems of mutant `number`, and what it became."""
        scene, name = self.mutant(number, folder)
        work = folder / "work"
        work.mkdir()
        found, outcome = [], "refused"
        for command, options in [("check", []), ("run", ["-n", "3", "--quiet", "--record", "out"])]:
            problem, code = self.run(command, [str(scene), *options], work)
            if problem:
                found.append(f"{name}: {command}: {problem}")
            outcome = {0: "ran", 3: "no result"}.get(code, outcome) if command == "run" else outcome
        for path in sorted(work.rglob("*")):
            if path.is_file() and path.suffix != ".printed" and not_finite(path):
                found.append(f"{name}: not finite: {path.relative_to(work)}")
        return found, outcome

    def __call__(self, number):
        with tempfile.TemporaryDirectory(prefix="fuzz_scenes_") as name:
            folder = Path(name)
            found, outcome = self.problems(number, folder)
            if self.keep and (found or self.keep_all):
                shutil.copytree(folder, self.keep / f"{self.seed}_{number}", dirs_exist_ok=True)
        return number, found, outcome

    keep_all = False


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stroma", type=Path, default=TREE / "build/release/bin/stroma", help="the command")
    parser.add_argument("--scene", default="*", help="names of examples, as a shell would expand them")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--count", type=int, default=100, help="how many")
    parser.add_argument("--jobs", type=int, default=1, help="how many at once")
    parser.add_argument("--seconds", type=float, default=60, help="what a command may take")
    parser.add_argument("--memory", type=int, default=400, metavar="MB", help="what a process may take")
    parser.add_argument("--keep", type=Path, help="folder for mutants with a problem; with --count 1 for the one mutant")
    arguments = parser.parse_args()
    trial, outcomes, bad = Trial(arguments), Counter(), 0
    trial.keep_all = arguments.count == 1
    numbers = range(arguments.first, arguments.first + arguments.count)
    with concurrent.futures.ThreadPoolExecutor(arguments.jobs) as pool:
        for number, found, outcome in pool.map(trial, numbers):
            outcomes[outcome] += 1
            bad += bool(found)
            for problem in found:
                print(f"mutant {number}: {problem}", flush=True)
    told = ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    print(f"{arguments.count} mutants with seed {arguments.seed}: {told}; {bad} with problems")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
