# SPDX-License-Identifier: LGPL-2.1-or-later
"""A scene stepped from Python has the bits of `stroma run`, and so has the same scene written by Python and read again."""
import os
import pathlib
import subprocess
import sys

import pytest
import stroma
from conftest import EXAMPLES, PATIENCE, SOURCE

STEPS = 3
LONG = {"organ_fine.xml"}  # the components of organ.xml, and a minute more
SCENES = sorted(path.name for path in EXAMPLES.glob("*.xml") if path.name not in LONG)


def of_the_command(scene, *more):
    """The hash of what the command has computed, read from its checkpoint."""
    run = subprocess.run([os.environ["STROMA_COMMAND"], "run", str(scene), "-n", str(STEPS), "--quiet", "--record", "recorded", *more],
                         capture_output=True, text=True, timeout=PATIENCE)
    assert run.returncode == 0, run.stderr
    settings = dict(word.split("=") for word in more if "=" in word)
    simulation = stroma.load(scene, set=settings, observers=False)
    simulation.restore(pathlib.Path("recorded/last.checkpoint").read_bytes())
    assert simulation.steps == STEPS
    return simulation.hash


@pytest.mark.parametrize("name", SCENES)
def test_every_example_has_the_bits_of_the_command(name, folder):
    simulation = stroma.load(EXAMPLES / name)
    simulation.run(STEPS)
    simulation.finish()
    assert simulation.hash == of_the_command(EXAMPLES / name)
    again = stroma.load(stroma.from_xml(EXAMPLES / name), observers=False)
    for _ in range(STEPS):
        again.step()
    assert again.hash == simulation.hash, "as a tree of Python"


@pytest.mark.parametrize("first", ["numpy", "stroma"])
def test_who_comes_first_changes_no_bit(first, folder):
    """numpy opens OpenBLAS, which a direct solver multiplies by, and it chooses its kernels then."""
    scene = EXAMPLES / "pressure.xml"
    program = f"import {first}, numpy, stroma; numpy.ones((99, 99)) @ numpy.ones((99, 99)); " \
              f"simulation = stroma.load({str(scene)!r}, observers=False, quiet=True); simulation.run({STEPS}); print(simulation.hash)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    assert int(done.stdout) == of_the_command(scene)


def test_a_scene_written_by_python_is_read_as_it_was(folder):
    tree = stroma.from_xml(EXAMPLES / "organ.xml")
    text = stroma.to_xml(tree).replace("../meshes", str(SOURCE / "scenes" / "meshes"))
    (folder / "organ.xml").write_text(text)
    written = stroma.load("organ.xml", observers=False)
    written.run(STEPS)
    read = stroma.load(EXAMPLES / "organ.xml", observers=False)
    read.run(STEPS)
    assert written.hash == read.hash


def test_overrides_are_those_of_the_command(folder):
    changed = stroma.load(EXAMPLES / "cantilever.xml", set={"dt": 0.005}, observers=False)
    changed.run(STEPS)
    assert changed.hash == of_the_command(EXAMPLES / "cantilever.xml", "--set", "dt=0.005")


@pytest.mark.parametrize("name", ["suture.xml", "balls_in_a_bowl.xml"])
def test_the_command_goes_on_from_a_checkpoint_of_python(name, folder):
    """Which has the forces of constraints besides what the command keeps."""
    simulation = stroma.load(EXAMPLES / name, observers=False)
    simulation.run(STEPS - 1)
    (folder / "python.checkpoint").write_bytes(simulation.checkpoint())
    assert b"constraint forces" in simulation.checkpoint()
    simulation.run(1)
    assert simulation.hash == of_the_command(EXAMPLES / name, "--restart", "python.checkpoint")
