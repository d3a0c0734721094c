# SPDX-License-Identifier: LGPL-2.1-or-later
"""Windows of SOFA's interface, which are not there: scenes of robots that fill them run all the same."""
import pytest
from playing import run


def test_windows_take_what_they_are_given(capsys):
    import Sofa
    import Sofa.ImGui as MyGui

    root = Sofa.Core.Node("root")
    state = root.addObject("MechanicalObject", template="Rigid3", position=[0, 0, 0, 0, 0, 0, 1])
    MyGui.setIPController(root, root, state)
    MyGui.SimulationState.addData("TCP", "Frame", state.position)
    MyGui.MyRobotWindow.addSettingInGroup("angle", state.position, -1, 1, "group")
    MyGui.MoveWindow.setTCPLimits(-100, 100, -3, 3)
    MyGui.ConnectionWindow.addThing(1)
    assert MyGui.getRobotConnectionToggle() is False and MyGui.MyRobotWindow.getSelectedPort() == ""
    with pytest.raises(AttributeError, match="Sofa.ImGui has no 'nothing'"):
        MyGui.nothing()


def test_a_scene_with_windows_runs(tmp_path):
    (tmp_path / "scene.py").write_text("""import Sofa
import Sofa.ImGui as MyGui

class Follow(Sofa.Core.Controller):
    def onAnimateBeginEvent(self, event):
        self.connected = MyGui.getRobotConnectionToggle()

def createScene(root):
    root.addObject("EulerImplicitSolver")
    root.addObject("CGLinearSolver", iterations=25, tolerance=1e-9, threshold=1e-9)
    state = root.addObject("MechanicalObject", position=[[0, 0, 0]])
    root.addObject("UniformMass", totalMass=1)
    MyGui.PlottingWindow.addData("y", state.position)
    root.addObject(Follow(name="follow"))
""")
    done = run("run", tmp_path / "scene.py", "-n", 3, "--no-record", folder=tmp_path)
    assert done.returncode == 0 and done.stderr.count("Sofa.ImGui has no windows here") == 1, done.stderr


def test_the_scheduler_and_the_factory_answer():
    import Sofa
    from Sofa.Core import TaskScheduler

    before = TaskScheduler.getThreadCount()
    TaskScheduler.init(1)
    assert TaskScheduler.getThreadCount() == 1
    TaskScheduler.init(before)
    TaskScheduler.stop()
    entry = Sofa.Core.ObjectFactory.getComponent("UniformMass")
    assert entry.className == "UniformMass" and entry.targets and entry.templates == [] and entry.description
    assert Sofa.Core.ObjectFactory.getComponent("NothingOfThatName") is None
