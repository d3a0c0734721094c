// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/simulation/simulation.h"

namespace stroma::test {

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
