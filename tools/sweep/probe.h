// SPDX-License-Identifier: LGPL-2.1-or-later
// Loads the scene with every value before anything is run: what is misspelt is refused, and what the meshes and time steps
// are is known.
#pragma once
#include <set>
#include <string>
#include <vector>

#include "tools/sweep/configuration.h"
#include "tools/sweep/error_measure.h"

namespace stroma::sweep {

struct Probed {
  using Files = std::set<std::string>;
  Files inputs;  ///< files that the scene reads, with any of the values
  /// Those that it reads with each value of each axis, and the first ones of the others. A value that it refuses has none.
  std::vector<std::vector<Files>> of_value;
  Files of_reference;  ///< with --reference-set

  /// Those that it reads with these values, as far as one of them alone decides; `choice` as that of a Configuration.
  Files inputsWith(const std::vector<std::size_t>& choice) const;
};

/// Completes the kinds and sizes of the axes. Throws std::invalid_argument with the messages of `stroma run` when a value
/// of --vary or --zip cannot be, or when the scene itself cannot be loaded. A value that only some of the others bear is
/// left to the runs. Works in a folder of its own below `request.folder`, which is removed.
Probed probe(const SweepRequest& request, std::vector<Axis>& axes, const ErrorMeasure& measure);

}  // namespace stroma::sweep
