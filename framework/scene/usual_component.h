// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>
#include <string>

namespace stroma {

class Component;

/// Components that the engine asks for by their role: where a scene leaves them out, and in messages that say what to write.
enum class Part {
  state,
  mass,           ///< whose sum is given
  diagonal_mass,  ///< of a mesh with a density
  integrator,
  solver_in_time,        ///< of matrices that a mass keeps well-conditioned
  solver_of_equilibria,  ///< of any matrix, by a factorisation
  solver_that_chooses,   ///< of any matrix, by the lowest estimated cost
  ball                   ///< a force on the points inside it
};

/// The component that usually plays it. tools/sofa answers: no name of a component is known here.
std::string usualComponent(Part part);
/// Makes one with its defaults, in no node and before its init(), for code that finds during the run that it needs one.
/// Throws std::runtime_error when its module cannot be opened.
std::unique_ptr<Component> makeUsual(Part part);

}  // namespace stroma
