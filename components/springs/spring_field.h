// SPDX-License-Identifier: LGPL-2.1-or-later
// What all components made of springs share. With d = x_b - x_a, L = |d|, n = d / L, and u = (v_b - v_a).n, a spring of
// stiffness k, damping c and rest length L0 has
//
//   E = k/2 (L - L0)^2,   f_a = -f_b = (k (L - L0) + c u) n
//   df_a/dx_a = -k [n n^T + (1 - L0/L) (I - n n^T)],   df_a/dv_a = -c n n^T
//
// A spring that only resists elongation has no energy, force or stiffness while L <= L0, one that only resists compression none
// while L >= L0. The direction n of a spring whose ends meet is not defined: with L0 = 0 force and stiffness are -k d and -k I
// all the same; with L0 > 0 the force is zero there (it points every way) and the stiffness -k I. The turning of n is left out
// of the derivative of the damping force with respect to x: it would make the stiffness unsymmetric.
#pragma once
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/node_group_field.h"

namespace stroma {

struct Spring {
  Index a = 0, b = 0;    ///< nodes: a of SpringField::state(), b of SpringField::second()
  double stiffness = 0;  ///< [N/m]
  double damping = 0;    ///< [N s/m]
  double length = 0;     ///< at rest [m]
  bool elongation_only = false;
  bool compression_only = false;
};

// With `explicitDamping` the damping is that of SOFA: it adds c u to the tension t of f_a = t n, nothing to df/dv, and the
// tangent is df_a/dx_a = -(k - t/L) n n^T - t/L I with that t. With `meetingEnds` free, as in SOFA, a spring
// does nothing where L is not above 1e-9 m, and has no stiffness there.

/// Springs between nodes of one state or of two.
class SpringField : public NodeGroupField<2, PairTangent>, public DrawnSegments {
 public:
  std::vector<State*> states() const override;
  ForceTraits traits() const override;
  /// 71,000 springs of a block in 0.29 ms, and in 4 ms: each block goes to a place of its own. Damping has a product of its own:
  /// 30,656 springs take 0.23 ms with it. Its blocks find the places of the stiffness in the cache.
  Cost cost() const override {
    const double springs = double(springs_.size()), products = traits().velocity_dependent ? 2 : 1;
    return {products * 4.2 * springs, 55 * springs};
  }
  void compile() override;
  double energy(ConstRows x) const override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  std::string worstElement(ConstRows x) const override;
  void addSegments(std::vector<Segment>& segments) const override;

 protected:
  void declareDamping(DataTable& table);  ///< explicitDamping, meetingEnds
  /// Called in init(), after ForceField::init(): the springs, and the state of their second ends when it is another.
  /// Throws ComponentError for a number that no spring can have.
  void setSprings(std::vector<Spring> springs, State* second = nullptr);
  State& second() const { return second_ ? *second_ : state(); }
  const std::vector<Spring>& springs() const { return springs_; }
  /// From the next addForce() on. A field whose lengths change over time says so in its traits.
  void setLength(std::size_t spring, double length) { springs_[spring].length = length; }
  /// Distance of the ends at rest [m].
  double restDistance(const Spring& spring) const;

 private:
  std::vector<Spring> springs_;
  State* second_ = nullptr;
  bool damped_ = false, rests_ = false;  ///< some spring has a damping; all have the length of the rest shape
  bool explicit_damping_ = false;
  enum class MeetingEnds : int { stiff, free };
  MeetingEnds meeting_ends_ = MeetingEnds::stiff;
};

}  // namespace stroma
