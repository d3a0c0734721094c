// SPDX-License-Identifier: LGPL-2.1-or-later
// What is compared between a run and the reference, as a list of vectors with a norm: displacements at common points, or
// one number, vector or tensor.
#pragma once
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/sweep/common_points.h"

namespace stroma::sweep {

using Values = std::vector<Vec3>;

/// Of a number, a vector, or a symmetric tensor xx yy zz xy yz zx, whose shears stand for two entries each: vectors with the
/// norm of them all.
Values vectorsOf(const std::vector<double>& numbers);

struct ErrorMeasure {
  enum class Kind {
    l2,        ///< sqrt(integral |u - u_ref|^2 dV / integral |u_ref|^2 dV) of the displacements at the end
    max,       ///< max |u - u_ref| / max |u_ref|
    energy,    ///< of kinetic and elastic energy at the end
    quantity,  ///< of a mean that the run tells
    place,     ///< of the displacement, position or velocity of one place of a state
  };
  Kind kind = Kind::l2;
  std::string text;         ///< as it was written
  std::string quantity;     ///< PATH.NAME[:NODES]
  std::string state, name;  ///< of a place
  Vec3 place = Vec3::Zero();

  /// --error. Throws std::invalid_argument with a sentence.
  static ErrorMeasure parse(const std::string& text);
  bool isField() const { return kind == Kind::l2 || kind == Kind::max; }
  /// Whether the run itself must tell it: `--measure-value quantity`.
  bool asksRun() const { return kind == Kind::quantity; }
  /// "L2 error of the displacements"
  std::string title() const;

  /// Of a run. `points` for fields. Throws std::runtime_error with a sentence.
  Values valuesOf(const EndState& end, const nlohmann::json& summary, const CommonPoints& points) const;
  double norm(const Values& values, const CommonPoints& points) const;
  /// Cosine of the angle between two lists as vectors, by the weights of the points; 0 when one of them vanishes.
  double cosine(const Values& a, const Values& b, const CommonPoints& points) const;
  double distance(const Values& a, const Values& b, const CommonPoints& points) const;
};

}  // namespace stroma::sweep
