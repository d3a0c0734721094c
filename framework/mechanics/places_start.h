// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>

#include "framework/algebra/vector.h"

namespace stroma {

/// A force field that moves nodes before the first step, because a run cannot start where they are.
class PlacesStart {
 public:
  virtual ~PlacesStart() = default;
  /// x: positions of all rows, of which the first `independent` may be moved; `project` takes out of displacements of these what
  /// is held. Throws ComponentError where there is no such place.
  virtual void placeStart(Rows x, Index independent, const std::function<void(Rows)>& project) = 0;
};

}  // namespace stroma
