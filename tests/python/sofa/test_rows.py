# SPDX-License-Identifier: LGPL-2.1-or-later
"""Each scene of rows.py by Sofa.Simulation, with what it says of itself, and by the command."""
import pytest
import rows
import Sofa
from playing import HERE, SCENES, animate, run

TO_ITS_OWN_ENDS = ("steps_while_it_is_built",)  # which says what it has to in createScene()


@pytest.mark.parametrize("create", rows.SCENES, ids=lambda create: create.__name__)
def test_in_ten_steps(create, folder, monkeypatch):
    monkeypatch.setenv("STROMA_DATA_PATH", str(SCENES))
    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    check = create(root)
    Sofa.Simulation.init(root)
    animate(root, 0 if create.__name__ in TO_ITS_OWN_ENDS else 10)
    if check is not None:
        check()


@pytest.mark.parametrize("create", rows.SCENES, ids=lambda create: create.__name__)
def test_by_the_command(create, folder):
    (folder / "scene.py").write_text(f"import sys\nsys.path.insert(0, {str(HERE)!r})\nfrom rows import {create.__name__} as createScene\n")
    done = run("run", "scene.py", "-n", 10, "--no-record", folder=folder, STROMA_DATA_PATH=str(SCENES))
    steps = 2 if create is rows.episodes_from_within else 10  # since the last of its beginnings
    assert done.returncode == 0 and f"{steps} steps" in done.stdout and "Traceback" not in done.stderr, done.stderr


def test_a_listener_of_nothing_says_so(folder):
    """Links that lead to no collision model, and a scene in which nothing answers contacts."""
    root = Sofa.Core.Node("root")
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("MechanicalObject", name="mo")
    wrong = root.addObject("ContactListener", collisionModel1="@body/mo", collisionModel2="@body/model")
    with pytest.raises(RuntimeError, match="collisionModel1 leads to /body/mo, which is no collision model"):
        wrong.getDistances()
    body.addObject("PointCollisionModel", name="model")
    wrong.collisionModel1 = "@body/model"
    Sofa.Simulation.init(root)
    assert wrong.getNumberOfContacts() == 0 and wrong.getContactPoints() == []


def test_there_are_many():
    assert len(rows.SCENES) >= 27 and all(create.__doc__ for create in rows.SCENES)
