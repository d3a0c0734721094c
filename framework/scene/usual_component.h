// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

namespace stroma {

class Component;

/// What the engine asks for by the part it plays: where a scene leaves it out, and in messages that say what to write.
enum class Part {
  state,
  mass,           ///< whose sum is given
  diagonal_mass,  ///< of a mesh with a density
  integrator,
  solver_in_time,        ///< of matrices that a mass keeps well-conditioned
  solver_of_equilibria,  ///< of any matrix, by a factorisation
  solver_that_chooses    ///< of any matrix, by what costs least
};

/// The component that usually plays it. tools/sofa answers: no name of a component is known here.
std::string usualComponent(Part part);
/// One of these, in no node and with its defaults, for a component that finds in the run that it needs it. Throws
/// std::runtime_error when its module cannot be opened.
std::unique_ptr<Component> makeUsual(Part part);

}  // namespace stroma
