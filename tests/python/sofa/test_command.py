# SPDX-License-Identifier: LGPL-2.1-or-later
"""The command on scenes in Python: it runs them as it runs XML, and tells all that is missing at once."""
import gzip
import json
import re
import signal
import subprocess
import sys

import pytest
from playing import COMMAND, HERE, PATIENCE, SCENES, run

sys.path.insert(0, str(HERE.parents[1] / "view"))  # pages that need no browser

GOOD = ["free_fall", "value_kinds", "links", "driven", "writeable", "before_init", "user_data", "by_keys", "any_event", "removed_before",
        "prefab", "reinit", "older_python", "python_two", "gui_main", "two_parents", "with_library", "with_module", "names", "rigid",
        "follower", "late_controller", "target", "goal", "detached", "forces_read", "deactivated", "own_force"]


@pytest.mark.parametrize("name", GOOD)
def test_runs(name, folder):
    done = run("run", SCENES / f"{name}.py", "-n", 10, "--no-record", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "10 steps" in done.stdout


def test_check_tells_counts(folder):
    done = run("check", SCENES / "value_kinds.py", folder=folder)
    assert done.returncode == 0 and "45 nodes in 1 state, 2 force fields" in done.stdout


def test_settings_and_summary(folder):
    done = run("run", SCENES / "with_module.py", "--until", 0.5, "--set", "/.dt=0.1", "--no-record", "--json", "out.json", folder=folder)
    assert done.returncode == 0, done.stderr
    summary = json.loads((folder / "out.json").read_text())
    assert summary["steps"] == 5
    for file in (SCENES / "with_module.py", SCENES / "parts_of_scene.py", SCENES / "data" / "mesh" / "box.obj"):
        assert str(file) in summary["inputs"], summary["inputs"]


def test_profiles(folder):
    """It starts the program again, be it the command or Python."""
    done = run("run", SCENES / "driven.py", "-n", 4, "--no-record", "--profile", "trace.json", folder=folder)
    assert done.returncode == 0 and "4 steps" in done.stdout, done.stderr
    events = json.loads((folder / "trace.json").read_text())["traceEvents"]
    assert sum(event.get("name", "").startswith("step") for event in events) >= 4


def test_records(folder):
    done = run("run", SCENES / "driven.py", "-n", 4, "--record", "kept", folder=folder)
    assert done.returncode == 0, done.stderr
    assert list((folder / "kept").iterdir())
    assert f"to look at it: {COMMAND} view kept" in done.stdout, done.stdout


@pytest.mark.parametrize("name", ["organ", "pressure", "two_bodies", "ten_tetrahedra", "soft_between_rigid", "cantilever"])
def test_a_tree_of_python_has_the_bits_of_its_xml(name, folder):
    import Sofa

    file = HERE.parents[2] / "scenes" / "examples" / f"{name}.xml"
    done = run("run", file, "--dialect", "sofa", "-n", 3, "--no-record", "--json", "out.json", folder=folder)
    assert done.returncode == 0, done.stderr
    root = Sofa.Simulation.load(str(file))
    Sofa.Simulation.init(root)
    for _ in range(3):
        Sofa.Simulation.animate(root)
    assert f"{root._s_running.sim.hash:016x}" == json.loads((folder / "out.json").read_text())["state_hash"]


def test_explains(folder):
    done = run("explain", SCENES / "driven.py", folder=folder)
    assert done.returncode == 0 and "EulerImplicitSolver" in done.stdout


def test_regression(folder):
    (folder / "list").write_text(f"references\n{SCENES / 'driven.py'} 5 1e-9\n")
    stored = run("regress", "list", "--update", folder=folder)
    assert stored.returncode == 0, stored.stderr
    compared = run("regress", "list", folder=folder)
    assert compared.returncode == 0 and "1 passed" in compared.stdout, compared.stdout + compared.stderr
    texts = [gzip.decompress(each.read_bytes()).decode() for each in (folder / "references").rglob("*.gz")]
    heights = [float(line.split()[-1]) for text in texts for line in text.splitlines() if line.strip().startswith("X")]
    # v_n is the sum of 0.1 * 3 k / 1.5 up to n, and x the sum of 0.1 v_n: 0.01 * (2 + 6 + 12 + 20 + 30)
    assert heights[-1] == pytest.approx(0.7, rel=1e-9), texts


def test_changed_tree_is_run_again(folder):
    done = run("run", SCENES / "released.py", "-n", 8, "--no-record", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "changes its tree" in done.stderr and done.stdout.strip() == "8 steps, t = 0.8 s"


def test_a_scene_that_waits_for_others_does_not_hang(folder):
    (folder / "waits.py").write_text("import socket\n\n\ndef createScene(root):\n    server = socket.socket()\n"
                                     "    server.bind(('localhost', 0))\n    server.listen(1)\n    server.accept()\n")
    done = run("run", "waits.py", "-n", 1, folder=folder, STROMA_SOCKET_SECONDS="0.2")
    assert done.returncode == 2 and "waits.py:8: error: TimeoutError" in done.stderr, done.stderr
    (folder / "asks.py").write_text("def createScene(root):\n    input('how many?')\n")
    done = run("run", "asks.py", "-n", 1, folder=folder)
    assert done.returncode == 2 and "asks.py:2: error: EOFError" in done.stderr, done.stderr


def test_all_that_is_missing_is_told_at_once(folder):
    done = run("run", SCENES / "lacking.py", "-n", 1, folder=folder)
    assert done.returncode == 2
    for line, words in ((3, "nosuchlibrary"), (8, "CarvingNothing"), (10, "FluidGridSolver9")):
        assert re.search(rf"lacking.py:{line}: error: .*{words}", done.stderr), done.stderr
    assert "3 errors: nothing was run" in done.stderr


def test_unknown_components_have_the_line_of_the_scene(folder):
    done = run("check", SCENES / "unknown_types.py", folder=folder)
    assert done.returncode == 2
    assert re.search(r"unknown_types.py:7: error: /first: .*CarvingNothing", done.stderr), done.stderr
    assert re.search(r"unknown_types.py:11: error: /body/second: .*FluidGridSolver9", done.stderr), done.stderr
    told = json.loads(run("check", SCENES / "unknown_types.py", "--json", folder=folder).stdout)
    assert [problem["line"] for problem in told["problems"] if problem["severity"] == "error"] == [7, 11]


def test_a_scene_that_fails(folder):
    done = run("run", SCENES / "fails.py", "-n", 1, folder=folder)
    assert done.returncode == 2
    assert "fails.py:7: error: " in done.stderr and "fails.py:10: error: " in done.stderr, done.stderr


def test_files_that_are_missing_are_told_with_the_rest(folder):
    done = run("run", SCENES / "no_file.py", "-n", 1, folder=folder)
    assert done.returncode == 2
    for line, words in ((6, "none.obj.*is not found"), (7, "CarvingNothing"), (8, "IndexError")):
        assert re.search(rf"no_file.py:{line}: error: .*{words}", done.stderr), done.stderr
    assert "3 errors: nothing was run" in done.stderr


def test_a_controller_that_fails(folder):
    done = run("run", SCENES / "fails_in_step.py", "-n", 5, "--no-record", folder=folder)
    assert done.returncode == 3
    assert re.search(r"fails_in_step.py:12: IndexError: pop from empty list", done.stderr), done.stderr
    assert "t = 0.02" in done.stderr, "two steps were made"


def test_a_force_that_fails(folder):
    done = run("run", SCENES / "force_fails.py", "-n", 5, "--no-record", folder=folder)
    assert done.returncode == 3 and "Traceback" not in done.stderr
    assert re.search(r"force_fails.py:12: IndexError: pop from empty list: the force has no value", done.stderr), done.stderr
    assert "/body/force acts on it" in done.stderr and "the last good state (t = 0.01)" in done.stderr, done.stderr
    (folder / "other.py").write_text(f"import sys\nsys.path.insert(0, {str(SCENES)!r})\nimport force_fails\n\n\n"
                                     "def createScene(root):\n    force_fails.createScene(root, force_fails.OtherValues, 'EulerImplicitSolver')\n")
    done = run("run", "other.py", "-n", 5, "--no-record", folder=folder)
    assert done.returncode in (2, 3) and re.search(r"force_fails.py:19: TypeError: .*addKToMatrix\(\)", done.stderr), done.stderr
    assert "At:" not in done.stderr, done.stderr


def test_files_and_threads_of_a_scene(folder):
    (folder / "writes.py").write_text("import threading\nimport time\n\nFILE = open('out.txt', 'w')\n\n\ndef createScene(root):\n"
                                      "    FILE.write('written')\n    threading.Thread(target=time.sleep, args=(100000,)).start()\n")
    done = run("run", "writes.py", "-n", 1, "--no-record", folder=folder)
    assert done.returncode == 0, done.stderr
    assert (folder / "out.txt").read_text() == "written", "though nobody closes it"


def test_processes_of_a_scene_do_not_keep_the_command(folder):
    (folder / "starts.py").write_text("import multiprocessing\nimport time\n\n\ndef createScene(root):\n"
                                      "    multiprocessing.Process(target=time.sleep, args=(3600,)).start()\n")
    done = run("run", "starts.py", "-n", 1, "--no-record", folder=folder)
    assert done.returncode == 0, done.stderr


def test_a_scene_that_is_run_again_hears_sigterm(folder):
    """The command waits for the signal in a thread, which is not there any more."""
    text = (SCENES / "released.py").read_text()
    (folder / "long.py").write_text(text)
    process = subprocess.Popen([COMMAND, "run", "long.py", "-n", "1000000000", "--no-record"], stderr=subprocess.PIPE, cwd=folder, text=True)
    assert any("run again" in line for line in process.stderr)
    process.send_signal(signal.SIGTERM)
    try:
        assert process.wait(PATIENCE) in (-signal.SIGTERM, 128 + signal.SIGTERM)
    finally:
        process.kill()


def test_a_controller_may_end_the_run(folder):
    (folder / "ends.py").write_text("import sys\n\nimport Sofa\n\n\nclass End(Sofa.Core.Controller):\n"
                                    "    def onAnimateEndEvent(self, event):\n        sys.exit(0)\n\n\ndef createScene(root):\n    root.addObject(End())\n")
    done = run("run", "ends.py", "-n", 5, "--no-record", folder=folder)
    assert done.returncode == 3 and "ends.py:8: the scene ends the run here: sys.exit(0)" in done.stderr, done.stderr


@pytest.mark.parametrize("text, words", [
    ("def createScene(root)\n    pass\n", "expected ':'"),
    ("x = 1\n", "no function createScene"),
    ("import sys\ndef createScene(root):\n    sys.exit(3)\n", "ends the program"),
    ("def createScene(root):\n    root.addObject('MechanicalObject', position=[[0, 0]])\n    return 1 / 0\n", "ZeroDivisionError"),
])
def test_scenes_that_are_none(text, words, folder):
    (folder / "bad.py").write_text(text)
    done = run("run", "bad.py", "-n", 1, folder=folder)
    assert done.returncode == 2 and words in done.stderr, done.stderr
    assert "Traceback" not in done.stderr


def test_a_program_without_display(folder):
    import os
    import subprocess

    environment = {name: value for name, value in os.environ.items() if name not in ("DISPLAY", "WAYLAND_DISPLAY")}
    done = subprocess.run([sys.executable, str(SCENES / "gui_main.py")], capture_output=True, text=True, env=environment, timeout=PATIENCE)
    assert done.returncode == 0, done.stderr
    height = float(re.search(r"height (\S+)", done.stdout)[1])
    assert height == pytest.approx(5 - 10 * 0.01 * 10 * 11 / 2) and "start 5.0 0.0" in done.stdout
    shown = subprocess.run([sys.executable, str(SCENES / "gui_main.py"), "gui"], capture_output=True, text=True, env=environment,
                           timeout=PATIENCE)
    assert shown.returncode == 0 and "no display" in shown.stderr and "closed" in shown.stdout


def test_the_view_hands_keys_to_controllers():
    from server import Server

    with Server(COMMAND, str(SCENES / "by_keys.py"), "--paused") as server:
        page = server.page()
        page.do("control")
        assert page.scene["keys"] is True
        page.do("key", key="ArrowUp", pressed=True)
        page.do("step", count=1)
        page.picture(1)
        assert page.positions()[0][2] == pytest.approx(1e-4, rel=1e-6), "pushed up: x = h^2"
        page.do("key", key="ArrowUp", pressed=False)
        page.do("key", key="-", pressed=True)
        page.do("step", count=2)
        page.picture(3)
        assert page.positions()[0][2] == pytest.approx(1e-4 * (1 + 0 - 1), abs=1e-9), "v is h, 0, -h"
        page.do("reset")
        page.picture(0)
        page.do("step", count=1)
        assert page.status["ended"] == ""


def test_the_view_hands_the_pointer_to_controllers():
    from server import Server

    with Server(COMMAND, str(SCENES / "by_mouse.py"), "--paused") as server:
        page = server.page()
        page.do("control")
        page.do("mouse", state=0, x=50, y=50, wheel=0)
        page.do("mouse", state=1, x=100, y=200, wheel=0)
        page.do("mouse", state=0, x=103, y=195, wheel=0)
        page.do("step", count=1)
        page.picture(1)
        assert page.positions()[0] == pytest.approx([3e-4, 5e-4, 0], rel=1e-5), "x = h^2 f / m, 3 N to the right and 5 N up"
        page.do("mouse", state=2, x=103, y=195, wheel=0)
        page.do("mouse", state=0, x=900, y=0, wheel=0)
        page.do("mouse", state=5, x=0, y=0, wheel=-120)
        page.do("step", count=1)
        page.picture(2)
        assert page.positions()[0] == pytest.approx([6e-4, 10e-4, -120e-4], rel=1e-5), "v stays in the plane"
        for wrong in ({"state": 8, "x": 0, "y": 0, "wheel": 0}, {"state": 1, "x": 0.5, "y": 0, "wheel": 0}, {"state": 1, "x": 0, "y": 0}):
            assert not page.ask("mouse", **wrong)["ok"], wrong
        assert page.status["ended"] == ""


def test_migrate_names_what_is_written_in_python(folder):
    scene = folder / "led.py"
    scene.write_text('''import Sofa
class Leading(Sofa.Core.Controller):
    pass
def createScene(root):
    root.addObject("DefaultAnimationLoop")
    body = root.addChild("body")
    body.addObject("EulerExplicitSolver")
    body.addObject("MechanicalObject", position=[[0, 0, 0]])
    body.addObject("UniformMass", totalMass=1)
    body.addObject(Leading(name="leading"))
''')
    done = run("migrate", scene, "-o", folder / "led.xml", folder=folder)
    assert done.returncode == 0, done.stderr
    assert "/body/leading: Leading is written in Python, and not in the scene that is made" in done.stderr
