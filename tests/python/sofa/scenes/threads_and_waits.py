# SPDX-License-Identifier: LGPL-2.1-or-later
"""A controller that starts a thread which fills a queue, waits a little, and reads what has come; time by the clock."""
import queue
import threading
import time

import Sofa


class Sensor(threading.Thread):
    def __init__(self, out):
        super().__init__(daemon=True)
        self.out, self.running = out, True

    def run(self):
        value = 0.0
        while self.running:
            value += 1.0
            self.out.put(value)
            time.sleep(0.001)


class FromSensor(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.load = kwargs["load"]
        self.queue = queue.Queue()
        self.sensor = Sensor(self.queue)
        self.sensor.start()
        self.lock = threading.Lock()

    def onAnimateBeginEvent(self, event):
        with self.lock:
            value = self.queue.get()
        self.load.totalForce = [value * 0.01, 0, 0]

    def cleanup(self):
        self.sensor.running = False


def createScene(root):
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=10, tolerance=1e-9, threshold=1e-9)
    n.addObject("MechanicalObject", position=[[0, 0, 0]])
    n.addObject("UniformMass", totalMass=1)
    load = n.addObject("ConstantForceField", totalForce=[0, 0, 0], indices=0)
    root.addObject(FromSensor(name="FromSensor", load=load))
