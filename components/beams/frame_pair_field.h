// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces between two rigid frames that derive from an energy E of their relative placement:
//
//   p = R_a^T (c_b - c_a),   psi = log(R_a^T R_b)
//
// with R_a, R_b the axes fixed in the two frames. With n = dE/dp and k = dE/dpsi the force and the torque on frame b are, in
// the axes R_a, f = -n and m = -dexp^-T(psi) k; frame a gets -f and -m - p x f, so that forces and torques balance to
// round-off. The stiffness is the derivative of these, less its skew part: 1/2 [torque] of each frame, which adds up to zero
// over all that acts on a frame in equilibrium.
#pragma once
#include <algorithm>
#include <array>

#include "components/beams/pair_lanes.h"
#include "components/beams/relative_motion.h"
#include "framework/mechanics/drawn_segments.h"
#include "framework/mechanics/frames.h"
#include "framework/mechanics/node_group_field.h"

namespace stroma {

class FramePairField : public NodeGroupField<4>, public DrawnSegments {
 public:
  std::vector<State*> states() const override;
  ForceTraits traits() const override;
  void compile() override;
  void addForce(ConstRows x, ConstRows v, Rows f) override;
  void addSegments(std::vector<Segment>& segments) const override;

 protected:
  bool takesAllRows() const override { return true; }
  struct Pair {
    Index a = 0, b = 0;         ///< rows of the centres, of state() and of second()
    Quaternion axes_a, axes_b;  ///< R_a and R_b in the axes of the frames
    double damping = 0;         ///< of the relative velocity, f = -damping v, torque = -damping w [N s/m], [N m s]
  };
  /// In init(), after ForceField::init(). Throws ComponentError unless both states have frames.
  void setPairs(std::vector<Pair> pairs, State* second = nullptr);
  const std::vector<Pair>& pairs() const { return pairs_; }
  /// The axes of pairs(), after the pairs have been set anew during a run, with the same rows.
  void placeAxes();
  virtual double drawnRadius() const { return 0; }  ///< of beams [m]
  State& second() const { return second_ ? *second_ : state(); }

  template <class T>
  struct Wrench {
    Triple<T> n, k;  ///< dE/dp, dE/dpsi
    Pack energy = Pack(0.);
  };
  /// The placement of the frames b of a batch of pairs in the axes of the frames a.
  struct Placed {
    M3<Pack> axes;         ///< R_a
    V3<Pack> arm, p, psi;  ///< arm = c_b - c_a
    InverseTerm<Pack> term;  ///< of |psi|^2
  };
  std::size_t batches() const { return fixed_.size(); }
  Placed place(std::size_t batch, ConstRows x) const {
    Kept passing;
    return place(batch, x, passing);
  }
  /// The same, kept for tangents.
  Placed placeToKeep(std::size_t batch, ConstRows x) { return place(batch, x, kept_[batch]); }
  /// The data stored for a batch.
  Placed keptPlace(std::size_t batch) const;
  void addForces(std::size_t batch, const Placed& at, const Wrench<Pack>& wrench, Rows f) const;
  void writeTangents(std::size_t batch, const Placed& at, const Wrench<PackJet>& wrench) const;
  /// The number of pairs of a batch that are not repetitions.
  std::size_t pairsIn(std::size_t batch) const {
    return std::min(std::size_t(pack_lanes), pairs_.size() - batch * std::size_t(pack_lanes));
  }

 private:
  /// What of a batch stays: the last one repeats its last pair in lanes that are left over.
  struct alignas(64) Fixed {
    LanesOf<4> axes_a, axes_b;                                      ///< x y z w
    std::array<std::array<Index, std::size_t(pack_lanes)>, 4> rows; ///< of c_a, a, c_b, b, times row_doubles
  };
  struct Kept {
    LanesOf<4> axes;      ///< R_a as x y z w
    LanesOf<3> arm, psi;
  };
  Placed place(std::size_t batch, ConstRows x, Kept& kept) const;
  static Placed placed(const Orientation<Pack>& a, const V3<Pack>& arm, const V3<Pack>& psi) {
    const M3<Pack> axes = a.axes();
    return {axes, arm, transposedTimes(axes, arm), psi, InverseTerm<Pack>(dot(psi, psi))};
  }
  virtual void pull(ConstRows x, Rows f) = 0;  ///< all forces
  void damp(std::size_t pair, ConstRows x, ConstRows v, Rows f);

  std::vector<Pair> pairs_;
  State* second_ = nullptr;
  bool damped_ = false;
  bool are_laid_out_ = false;            ///< compile() has read pairs_
  std::array<Index, 2> first_rows_{};    ///< of both states then
  std::vector<Fixed> fixed_;
  std::vector<Kept> kept_;  ///< of the last addForce()
};

inline FramePairField::Placed FramePairField::place(std::size_t batch, ConstRows x, Kept& kept) const {
  const Fixed& fixed = fixed_[batch];
  const Orientation<Pack> axes_a{vectorIn(fixed.axes_a), packOf(fixed.axes_a[3])},
      axes_b{vectorIn(fixed.axes_b), packOf(fixed.axes_b[3])};
  const Orientation<Pack> a = orientationsAt(x.data, fixed.rows[1].data()) * axes_a;
  const Orientation<Pack> b = orientationsAt(x.data, fixed.rows[3].data()) * axes_b;
  const V3<Pack> arm = gatherRows(x.data, fixed.rows[2].data()) - gatherRows(x.data, fixed.rows[0].data());
  const V3<Pack> psi = (a.conjugate() * b).logarithm();
  put(a.v, kept.axes), a.w.store_aligned(kept.axes[3].data()), put(arm, kept.arm), put(psi, kept.psi);
  return placed(a, arm, psi);
}

inline void FramePairField::addForces(std::size_t batch, const Placed& at, const Wrench<Pack>& wrench, Rows f) const {
  // R_a n and R_a dexp^-T(psi) k: what frame a gets; frame b gets the opposite
  const V3<Pack> k{wrench.k.x, wrench.k.y, wrench.k.z}, once = cross(at.psi, k);
  const V3<Pack> force = at.axes * V3<Pack>{wrench.n.x, wrench.n.y, wrench.n.z};
  const V3<Pack> torque = at.axes * (k + once * Pack(0.5) + cross(at.psi, once) * at.term.c);
  const auto& rows = fixed_[batch].rows;
  const V3<Pack> each[4] = {force, torque + cross(at.arm, force), -force, -torque};
  const std::size_t count = pairsIn(batch);
  if (count == std::size_t(pack_lanes)) {
    for (std::size_t r = 0; r < 4; ++r) addToRows(each[r], rows[r].data(), f.data);
    return;
  }
  for (std::size_t r = 0; r < 4; ++r)
    forEachRow(each[r], [&](int lane, const auto& row) {
      if (std::size_t(lane) < count) addRow(row, f.data + rows[r][std::size_t(lane)]);
    });
}

/// `Energy` has evaluate(batch, p, psi, term), once for packs of numbers and of numbers with derivatives. The energy of pairs is
/// a pack.
template <class Energy>
class FramePairFieldOf : public FramePairField {
 public:
  double energy(ConstRows x) const override {
    double sum = 0;
    for (std::size_t i = 0; i < batches(); ++i) {
      const Placed at = place(i, x);
      LanesOf<1> energies;
      evaluated(i, tripleOf(at.p), tripleOf(at.psi), at.term).energy.store_aligned(energies[0].data());
      for (std::size_t lane = 0; lane < pairsIn(i); ++lane) sum += energies[0][lane];
    }
    return sum;
  }

 protected:
  void computeTangents() const override {
    for (std::size_t i = 0; i < batches(); ++i) {
      const Placed at = keptPlace(i);
      writeTangents(i, at, evaluated(i, variables(at.p, 0), variables(at.psi, 3), at.term));
    }
  }

 private:
  void pull(ConstRows x, Rows f) final {
    for (std::size_t i = 0; i < batches(); ++i) {
      const Placed at = placeToKeep(i, x);
      addForces(i, at, evaluated(i, tripleOf(at.p), tripleOf(at.psi), at.term), f);
    }
  }
  template <class T>
  Wrench<T> evaluated(std::size_t batch, const Triple<T>& p, const Triple<T>& psi, const InverseTerm<Pack>& term) const {
    return static_cast<const Energy&>(*this).evaluate(batch, p, psi, term);
  }
};

}  // namespace stroma
