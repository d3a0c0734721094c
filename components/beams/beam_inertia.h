// SPDX-License-Identifier: LGPL-2.1-or-later
// The consistent mass of beams, in the axes half way between those of their ends.
#pragma once
#include <Eigen/Core>
#include <functional>

#include "components/beams/beam_chain.h"
#include "framework/mechanics/node_group_field.h"

namespace stroma {

/// The beams of one field. Blocks are those of the rows c_a, a, c_b, b.
class BeamInertia {
 public:
  /// One for each beam of a chain, with its density [kg/m^3]; rows of the system.
  void set(const std::vector<ChainBeam>& beams, const std::vector<double>& densities, Index first_row);
  /// Sets M to the one at x.
  void place(ConstRows x);
  const std::vector<std::array<Index, 4>>& rows() const { return rows_; }
  const std::vector<DenseTangent<4>>& blocks() const;
  /// f += the forces by which momenta stay as M turns with the beams, at the x of the last place().
  void addTurning(ConstRows v, Rows f) const;
  double massOf(std::size_t beam) const { return masses_[beam]; }  ///< [kg]
  bool empty() const { return rows_.empty(); }

 private:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  /// Euler-Bernoulli, with the rotary inertia of the sections.
  static Matrix12 localMass(const ChainBeam& beam, double density);

  std::vector<std::array<Index, 4>> rows_;
  std::vector<double> masses_;
  std::vector<Matrix12> local_;
  std::vector<Quaternion> axes_a_, axes_b_, middles_;
  std::vector<Vec3> bends_;  ///< g = n tan(t/4) of the turn by t about n from one end to the other
  mutable std::vector<DenseTangent<4>> blocks_;
  mutable bool outdated_ = true;
};

/// The interface that AdaptiveBeamMass looks for in its node.
class HasBeamInertia {
 public:
  virtual ~HasBeamInertia() = default;
  /// Null: no mass.
  virtual BeamInertia* inertia() = 0;
  virtual const BeamChain& chain() const = 0;
  /// The mass of the whole rod [kg].
  virtual double wholeMass() const = 0;
  /// Called where the material of the beams may have changed.
  std::function<void()> tellMass = [] {};
};

}  // namespace stroma
