// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/elasticity/strain.h"

namespace stroma {

/// The matrix whose polar factor turns a cell: F, that of its edges, or sum (x_a - c)(X_a - C)^T of its nodes and their centres.
enum class PolarOf : int { gradient, edges, nodes };

enum class ElasticMethod : int { small, large, polar, svd, nodal, green };

/// What a scene chooses; checked by ElasticForceField.
struct ElasticVariant {
  ElasticMethod method = ElasticMethod::large;
  elastic::Update update = elastic::Update::none;
  bool exact_tangent = false;    ///< of the rotated methods
  bool mean_dilatation = false;  ///< the volume change is one number per element
  bool own_matrix = false;       ///< products through the field's own assembled matrix
};

}  // namespace stroma
