// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/elasticity/lame_of.h"

namespace stroma {

/// Of ElasticElements whose cells can have incompatible modes.
class HasIncompatibleModes {
 public:
  virtual ~HasIncompatibleModes() = default;
  /// Before bind(). The modes of a cell depend on its material, which is to outlive the cells.
  virtual void useIncompatibleModes(const LameOf& lame) = 0;
};

}  // namespace stroma
