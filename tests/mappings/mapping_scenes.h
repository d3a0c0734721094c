// SPDX-License-Identifier: LGPL-2.1-or-later
// Scenes with a mapping from frames or points.
#pragma once
#include <string>

namespace stroma::test {

inline const std::string frames =
    "<MechanicalObject name=\"frames\" template=\"Rigid3\" position=\"0 0 0  0.1 0.2 0.3 0.9   1 0.5 0  -0.4 0.1 0 0.8 "
    "  2 0 1  0 0 "
    "0 1\"/>"
    "<UniformMass totalMass=\"3\" inertia=\"0.1 0.2 0.3\"/>";

inline std::string underFrames(const std::string& child) {
  return "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>" + frames +
         "<Node name=\"child\">" + child + "</Node></Node>";
}
inline std::string underPoints(const std::string& child) {
  return "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/>"
         "<MechanicalObject name=\"points\" position=\"0 0 0  1 0.2 0  1.5 1 0.3  0 1 1\"/><UniformMass "
         "totalMass=\"4\"/>"
         "<Node name=\"child\">" +
         child + "</Node></Node>";
}

/// Frames in a cell that is turned and stretched where the scene starts.
inline std::string embeddedFrames(const std::string& cells, const std::string& rest, const std::string& position) {
  return "<Node name=\"root\" gravity=\"0 0 0\"><EulerImplicitSolver/><SparseLDLSolver/><MeshTopology name=\"net\" position=\"" +
         rest + "\" " + cells + "/><MechanicalObject name=\"points\" rest_position=\"" + rest + "\" position=\"" + position +
         "\"/><UniformMass totalMass=\"4\"/><Node name=\"child\"><MechanicalObject name=\"dofs\" template=\"Rigid3\" position=\"0.2 "
         "0.3 0.1  0.1 0.2 0.3 0.9   0.5 0.4 0.3  0 0 0 1\"/><BarycentricMapping useRestPosition=\"true\"/></Node></Node>";
}
inline const std::string rest_cube = "0 0 0  1 0 0  1 1 0  0 1 0  0 0 1  1 0 1  1 1 1  0 1 1";

}  // namespace stroma::test
