# SPDX-License-Identifier: LGPL-2.1-or-later
"""Cavities whose volume is measured."""
from Sofa import _libraries
from softrobots.actuators import _cavity

_libraries.same_module(__name__, "pneumaticSensor")


def PneumaticSensor(surfaceMeshFileName=None, attachedAsAChildOf=None, attachedTo=None, name="PneumaticSensor", rotation=[0.0, 0.0, 0.0],
                    translation=[0.0, 0.0, 0.0], uniformScale=1, initialValue=0, valueType="volumeGrowth"):
    sensor = _cavity("PneumaticSensor", surfaceMeshFileName, attachedAsAChildOf, attachedTo, name, rotation, translation, uniformScale)
    if sensor is not None:
        sensor.addObject("BarycentricMapping", name="Mapping", mapForces=False, mapMasses=False)
        sensor.addObject("SurfacePressureSensor", triangles="@topology.triangles")
    return sensor
