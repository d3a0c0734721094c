# SPDX-License-Identifier: LGPL-2.1-or-later
"""A cavity whose pressure a PID controller finds: properties, an effector that follows the body, data written as a scalar."""
import Sofa


class PID:
    def __init__(self, kp, ki, kd):
        self.kp, self.ki, self.kd, self.sum, self.last = kp, ki, kd, 0.0, None

    def __call__(self, error, dt):
        self.sum += error * dt
        change = 0 if self.last is None else (error - self.last) / dt
        self.last = error
        return self.kp * error + self.ki * self.sum + self.kd * change


class PressureController(Sofa.Core.Controller):
    def __init__(self, *args, cavity=None, effector=None, target=0, **kwargs):
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self._cavity, self._effector, self._target = cavity, effector, target
        self.pid = PID(0.01, 0.5, 0.0)
        self.pressures = []

    @property
    def pressure(self):
        return self._cavity.SurfacePressureConstraint.value.value[0]

    @pressure.setter
    def pressure(self, value):
        self._cavity.SurfacePressureConstraint.value = value

    def onAnimateBeginEvent(self, event):
        height = self._effector.MechanicalObject.position.value[0][1]
        self.pressure = max(0, self.pid(self._target - height, event['dt']))
        self.pressures.append(self.pressure)

    def onAnimateEndEvent(self, event):
        cavity = self._cavity.getObject('SurfacePressureConstraint')
        print(f"p = {cavity.pressure.value:.4f} V = {cavity.cavityVolume.value:.1f} ({cavity.initialCavityVolume.value:.1f})")


def createScene(rootNode):
    rootNode.addObject('RequiredPlugin', pluginName=['SoftRobots'])
    rootNode.gravity = [0, 0, 0]
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('GenericConstraintSolver', name='GCS', tolerance=1e-9, maxIterations=500, printLog=False)
    body = rootNode.addChild('body')
    body.addObject('EulerImplicitSolver', firstOrder=True, rayleighStiffness=0.1, rayleighMass=0.1)
    body.addObject('SparseLDLSolver')
    body.addObject('MeshVTKLoader', name='loader', filename='mesh/finger.vtk')
    body.addObject('MeshTopology', src='@loader', name='topo')
    body.addObject('MechanicalObject', name='mo')
    body.addObject('UniformMass', totalMass=0.1)
    body.addObject('TetrahedronFEMForceField', youngModulus=100, poissonRatio=0.4, method='large')
    body.addObject('BoxROI', name='box', box=[-1, -1, -1, 1, 21, 21])
    body.addObject('FixedConstraint', indices='@box.indices')
    body.addObject('GenericConstraintCorrection')
    cavity = body.addChild('cavity')
    cavity.addObject('MeshSTLLoader', name='loader', filename='mesh/cavity.stl')
    cavity.addObject('MeshTopology', src='@loader', name='topo')
    cavity.addObject('MechanicalObject', name='cavity')
    cavity.addObject('SurfacePressureConstraint', template='Vec3', value=0.0, triangles='@topo.triangles', valueType='pressure')
    cavity.addObject('BarycentricMapping', name='mapping', mapForces=False, mapMasses=False)
    effector = body.addChild('effector')
    effector.addObject('MechanicalObject', position=[80, 20, 10])
    effector.addObject('BarycentricMapping')
    rootNode.addObject(PressureController(name='controller', cavity=cavity, effector=effector, target=21))
