# SPDX-License-Identifier: LGPL-2.1-or-later
"""A rigid ball with a mesh falls on a soft block: penalties, two intersection methods of which the last counts, tabs in the text."""
import Sofa


def createScene(root):
	root.gravity = [0, -9.81, 0]
	root.dt = 0.002
	root.addObject('DefaultVisualManagerLoop')
	root.addObject('DefaultAnimationLoop')
	root.addObject('RequiredPlugin', pluginName="SofaImplicitOdeSolver SofaLoader SofaOpenglVisual SofaBoundaryCondition")
	root.addObject('DefaultPipeline', name="CollisionPipeline")
	root.addObject('BruteForceDetection', name="N2")
	root.addObject('DefaultContactManager', name="CollisionResponse", response="PenalityContactForceField")
	root.addObject('NewProximityIntersection', name="Proximity", alarmDistance=2, contactDistance=1)
	phantom = root.addChild('Phantom')
	phantom.addObject('EulerImplicitSolver', name="cg_odesolver", rayleighStiffness=0.1, rayleighMass=0.1)
	phantom.addObject('CGLinearSolver', name="linear_solver", iterations=25, tolerance=1e-15, threshold=1e-20)
	phantom.addObject('MeshVTKLoader', name="meshLoader", filename="mesh/finger.vtk")
	phantom.addObject('MeshTopology', src="@meshLoader")
	phantom.addObject('TetrahedronSetTopologyContainer', name="topo", src="@meshLoader")
	phantom.addObject('MechanicalObject', name="dofs", src="@meshLoader")
	phantom.addObject('TetrahedronSetGeometryAlgorithms', template="Vec3d", name="GeomAlgo")
	phantom.addObject('UniformMass', name="Mass", totalMass="0.22")
	phantom.addObject('TetrahedralCorotationalFEMForceField', template="Vec3d", name="FEM", method="large", poissonRatio=0.45,
						youngModulus=3000, computeGlobalMatrix=False)
	phantom.addObject('BoxROI', template="Vec3d", box="-1 -0.1 -1 81 0.1 21", name="FixedROI", drawBoxes="1", drawSize="1")
	phantom.addObject('FixedConstraint', name="fixROIindices", indices="@FixedROI.indices", showObject="True", drawSize="1")
	collision = phantom.addChild('Collision')
	collision.addObject('MeshSTLLoader', name="collMeshLoader", filename="mesh/finger.stl", rotation=[0, 0, 0])
	collision.addObject('MechanicalObject', name="collMesh", src="@collMeshLoader", template='Vec3d', listening=1)
	collision.addObject('MeshTopology', src='@collMeshLoader')
	collision.addObject('TriangleCollisionModel')
	collision.addObject('LineCollisionModel')
	collision.addObject('PointCollisionModel')
	collision.addObject('BarycentricMapping', name="CollisionMapping", input="@../dofs", output="@collMesh")
	ball = root.addChild("Sphere")
	ball.addObject('MechanicalObject', name="mstate", template="Rigid3", position=[40, 26, 10, 0, 0, 0, 1])
	ball.addObject('UniformMass', totalMass=0.01)
	ball.addObject('UncoupledConstraintCorrection')
	ball.addObject('EulerImplicitSolver', name='odesolver')
	ball.addObject('CGLinearSolver', name='Solver', iterations=25, tolerance=1e-15, threshold=1e-20)
	ballCollision = ball.addChild('collision')
	ballCollision.addObject('MeshOBJLoader', name="loader", filename="mesh/cube.obj", triangulate="true", scale=3)
	ballCollision.addObject('MeshTopology', src="@loader")
	ballCollision.addObject('MechanicalObject')
	ballCollision.addObject('TriangleCollisionModel')
	ballCollision.addObject('LineCollisionModel')
	ballCollision.addObject('PointCollisionModel')
	ballCollision.addObject('RigidMapping')
	return root
