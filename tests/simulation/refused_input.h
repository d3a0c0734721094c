// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/simulation.h"

namespace stroma::test {

/// One node of 1 kg at the origin that a spring of 100 N/m holds there.
inline std::string springScene(const std::string& integrator, const std::string& dt) {
  return "<Node name=\"root\" dt=\"" + dt + "\" gravity=\"0 0 0\">" + integrator +
         "<MechanicalObject name=\"dofs\" position=\"0 0 0\"/><UniformMass totalMass=\"1\"/>"
         "<RestShapeSpringsForceField stiffness=\"100\"/></Node>";
}

/// What addInput() says of an input that cannot act: "message|expected|suggestion".
inline std::string refusal(Simulation& simulation, const Input& input) {
  try {
    simulation.addInput(input);
  } catch (const ComponentError& error) {
    return std::string(error.what()) + "|" + error.expected + "|" + error.suggestion;
  }
  return "nothing was refused";
}

}  // namespace stroma::test
