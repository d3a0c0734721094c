# SPDX-License-Identifier: LGPL-2.1-or-later
"""A Cosserat catheter whose base a controller pushes and turns with SciPy's rotations, by `with ... writeableArray()`."""
import Sofa
from math import cos, pi, sin
from scipy.spatial.transform import Rotation as R


class CatheterController(Sofa.Core.Controller):
    def __init__(self, *args, **kwargs):
        # These are needed (and the normal way to override from a python class)
        Sofa.Core.Controller.__init__(self, *args, **kwargs)
        self.frames = kwargs['frame_node'].FramesMO
        self.base = kwargs['base'].RigidBaseMO
        self.rate = 0.2
        self.size = 0

    def onAnimateEndEvent(self, event):
        self.size = len(self.frames.position.value)
        with self.base.rest_position.writeableArray() as posA:
            posA[0][0] += self.rate
            q = R.from_quat(posA[0][3:]) * R.from_euler('x', 0.05)
            posA[0][3:7] = q.as_quat()
        tip = self.frames.position.value[self.size - 1][0:3]
        assert len(tip) == 3


def createScene(rootNode):
    rootNode.addObject('RequiredPlugin', pluginName='Cosserat SofaSparseSolver SofaImplicitOdeSolver', printLog='0')
    rootNode.findData('dt').value = 0.01
    rootNode.findData('gravity').value = [0., 0., 0.]
    rootNode.addObject('FreeMotionAnimationLoop')
    rootNode.addObject('GenericConstraintSolver', tolerance=1e-10, maxIterations=100)
    needle = rootNode.addChild('needle')
    needle.addObject('EulerImplicitSolver', rayleighStiffness=0.01)
    needle.addObject('SparseLUSolver', template='CompressedRowSparseMatrixd', printLog=False)
    needle.addObject('GenericConstraintCorrection')
    base = needle.addChild('rigidBase')
    base.addObject('MechanicalObject', template='Rigid3d', name='RigidBaseMO', position="0 0 0  0 0 0 1", showObject='1')
    base.addObject('RestShapeSpringsForceField', stiffness='50000', angularStiffness='50000', external_points='0',
                   mstate='@RigidBaseMO', points='0', template='Rigid3d')
    rate = needle.addChild('rateAngularDeform')
    rate.addObject('MechanicalObject', template='Vec3d', name='rateAngularDeformMO', position='0 0.01 0  0 0.01 0  0 0.01 0')
    rate.addObject('BeamHookeLawForceField', crossSectionShape='rectangular', lengthY=1., lengthZ=2., length='10 10 10', youngModulus=1e5,
                   poissonRatio=0.45)
    frames = base.addChild('MappedFrames')
    rate.addChild(frames)
    frames.addObject('MechanicalObject', template='Rigid3d', name='FramesMO',
                     position=[[10. * i, 0., 0., 0., 0., 0., 1.] for i in range(4)])
    frames.addObject('UniformMass', totalMass='0.00022')
    frames.addObject('DiscreteCosseratMapping', curv_abs_input='0 10 20 30', curv_abs_output=[0., 10., 20., 30.],
                     input1='@../../rateAngularDeform/rateAngularDeformMO', input2='@../RigidBaseMO', output='@FramesMO', debug='0')
    rootNode.addObject(CatheterController(name='ctrl', frame_node=frames, base=base))
