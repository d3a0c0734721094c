// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <array>
#include <string>
#include <vector>

#include "components/contact/contact_terms.h"

namespace stroma {
class Archive;
}

namespace stroma::contact {

/// Sums of contact forces on bodies and between each two of them, as attributes of a component. All obstacles count as one body,
/// which comes last.
class Wrenches {
 public:
  void declare(DataTable& table);
  /// `bodies`: the states that the surfaces of the law are of, in order.
  void compile(const BarrierLaw& law, const std::vector<State*>& bodies);
  /// Nothing pushes.
  void begin() { of_bodies_.assign(2 * bodies_, Vec3::Zero()), of_pairs_.assign(names_.size(), Vec3::Zero()); }
  /// A force c_i `force` on each vertex v_i, with all vertices at x: those of a pair, of which the first and the last are of its two
  /// bodies; -1: of a plane.
  void add(const Surfaces& surfaces, const std::array<int, 4>& v, const std::array<double, 4>& c, const std::vector<Vec3>& x,
           const Vec3& force);
  void serialize(Archive& archive);

 private:
  std::size_t bodyOf(const Surfaces& surfaces, int vertex) const;

  std::size_t bodies_ = 0;  ///< that are no obstacles
  std::size_t last_ = 0;    ///< the number of the last one, with obstacles as one more
  std::vector<std::string> names_;         ///< two for each pair
  std::vector<Vec3> of_bodies_, of_pairs_;  ///< force [N] and moment about the origin [N m]; of a pair on the first of both
};

}  // namespace stroma::contact
