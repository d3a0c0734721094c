# SPDX-License-Identifier: LGPL-2.1-or-later
"""All that draws and does nothing: lights, cameras, grids, labels, colour maps, post-processing, viewers, statistics, sliders."""


def createScene(root):
    for type, values in (("VisualStyle", dict(displayFlags="showAll hideWireframe")), ("BackgroundSetting", dict(color=[1, 1, 1, 1])),
                         ("LightManager", dict(ambient=[0.5] * 4)), ("DirectionalLight", dict(direction=[0, -1, 0])),
                         ("PositionalLight", dict(name="light1", color="0.8 0.8 0.8", position="0 60 50")),
                         ("SpotLight", dict(cutoff=30)),
                         ("OglSceneFrame", dict(style="CubeCones", alignment="BottomRight")), ("OglGrid", dict(nbSubdiv=10)),
                         ("LineAxis", dict(size=10)), ("VisualGrid", dict(nbSubdiv=10)), ("InteractiveCamera", dict(position=[0, 0, 10])),
                         ("RecordedCamera", dict(distance=3)), ("OglLabel", dict(label="text", fontsize=20)),
                         ("ViewerSetting", dict(resolution=[800, 600])),
                         ("OglColorMap", dict(colorScheme="Blue to Red")), ("DataDisplay", dict(name="display")),
                         ("AttachBodyButtonSetting", dict(stiffness=10)),
                         ("DefaultVisualManagerLoop", {}), ("OglShadowShader", {}), ("OglViewport", {})):
        root.addObject(type, **values)
    root.addObject("DefaultAnimationLoop")
    n = root.addChild("n")
    n.addObject("EulerImplicitSolver")
    n.addObject("CGLinearSolver", iterations=10, tolerance=1e-9, threshold=1e-9)
    n.addObject("MechanicalObject", name="mo", position=[[0, 0, 0], [1, 0, 0], [0, 1, 0]], drawMode=2, showColor=[1, 0, 0, 1])
    n.addObject("TriangleSetTopologyContainer", triangles=[[0, 1, 2]], position="@mo.position")
    n.addObject("UniformMass", totalMass=1, showGravityCenter=True, showAxisSizeFactor=0.1)
    v = n.addChild("visual")
    model = v.addObject("OglModel", name="visual", src="@../TriangleSetTopologyContainer",
                        material="Default Diffuse 1 1 0 0 1 Ambient 0 0 0 0 1", texturename="textures/of_nobody.png", isToPrint=True)
    v.addObject("IdentityMapping")
    model.setColor = None
    v.addObject("OglShader", fileVertexShaders=["a.vert"], fileFragmentShaders="b.frag")
    v.addObject("OglFloat3Variable", name="v", value="1 2 3")
    v.addObject("Visual3DText", text="here", position=[0, 0, 0], scale=0.1)
    n.addObject("ClipPlane", position=[0, 0, 0], normal=[1, 0, 0], active=False)
    n.addObject("TrailRenderer", position="@mo.position", nbSteps=10)
    n.addObject("PointSetGeometryAlgorithms", showPointIndices=True)
