// SPDX-License-Identifier: LGPL-2.1-or-later
// Forces between two rigid frames that have an energy E of how the one lies in the other:
//
//   p = R_a^T (c_b - c_a),   psi = log(R_a^T R_b)
//
// with R_a, R_b the axes of both as they are fixed in the frames. With n = dE/dp and k = dE/dpsi the force and the torque on
// frame b are, in the axes R_a, f = -n and m = -dexp^-T(psi) k; frame a gets -f and -m - p x f, so that forces and torques
// balance to round-off. The stiffness is the derivative of these, less its skew part: 1/2 [torque] of each frame, which adds
// up to zero over all that acts on a frame in equilibrium.
#pragma once
#include <array>
#include <utility>

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
  double energy(ConstRows x) const override;
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
  void computeTangents() const override;
  virtual double drawnRadius() const { return 0; }  ///< of beams [m]
  State& second() const { return second_ ? *second_ : state(); }

  template <class T>
  struct Wrench {
    Triple<T> n, k;  ///< dE/dp, dE/dpsi
    decltype(valueOf(std::declval<T>())) energy{};
  };
  /// How the frames b of a batch of pairs lie in the axes of the frames a, and what the energy says of them.
  struct Batch {
    LanesOf<9> axes;        ///< R_a in space, column by column
    LanesOf<3> arm, p, psi; ///< arm = c_b - c_a
    LanesOf<3> term;        ///< c, c', c'' of |psi|^2
    LanesOf<3> n, k;        ///< dE/dp, dE/dpsi
    InverseTerm<double> termOf(std::size_t lane) const {
      InverseTerm<double> of_lane;
      of_lane.c = term[0][lane], of_lane.c1 = term[1][lane], of_lane.c2 = term[2][lane];
      return of_lane;
    }
  };
  /// Derivatives of n and k by (p, psi): six for each of the three numbers.
  struct Slopes {
    LanesOf<18> n, k;
  };
  /// Writes n and k of each pair. Returns the energy.
  virtual double evaluateAll(std::vector<Batch>& batches) const = 0;
  virtual void evaluateAll(const std::vector<Batch>& batches, std::vector<Slopes>& out) const = 0;

 private:
  void place(ConstRows x, std::vector<Batch>& batches) const;
  void damp(std::size_t pair, ConstRows v, const Vec3& arm, Rows f);

  /// What of a batch stays: the last one repeats its last pair in lanes that are left over.
  struct alignas(64) Fixed {
    LanesOf<4> axes_a, axes_b;                                      ///< x y z w
    std::array<std::array<Index, std::size_t(pack_lanes)>, 4> rows; ///< of c_a, a, c_b, b, times row_doubles
  };

  std::vector<Pair> pairs_;
  State* second_ = nullptr;
  bool damped_ = false;
  std::vector<Fixed> fixed_;
  mutable std::vector<Batch> batches_, work_batches_;  ///< of the last addForce(); of energy()
  mutable std::vector<Slopes> slopes_;
};

/// `Energy` has evaluate(pair, p, psi, term), once for all number types; in packs evaluate(batch, p, psi, term).
template <class Energy, bool in_packs = false>
class FramePairFieldOf : public FramePairField {
 private:
  const Energy& energyOf() const { return static_cast<const Energy&>(*this); }
  /// visit(pair, batch, lane) for each pair.
  template <class Batches, class Visit>
  void forEach(Batches& batches, Visit&& visit) const {
    std::size_t i = 0;
    for (auto& batch : batches)
      for (std::size_t lane = 0; lane < std::size_t(pack_lanes) && i < pairs().size(); ++lane) visit(i++, batch, lane);
  }
  template <class Triple3>
  static Triple<Pack> packsOf(const Triple3& lanes) {
    return {packOf(lanes[0]), packOf(lanes[1]), packOf(lanes[2])};
  }
  static InverseTerm<Pack> termOf(const Batch& batch) {
    InverseTerm<Pack> term;
    term.c = packOf(batch.term[0]), term.c1 = packOf(batch.term[1]), term.c2 = packOf(batch.term[2]);
    return term;
  }
  double evaluateAll(std::vector<Batch>& batches) const final {
    double sum = 0;
    if constexpr (in_packs) {
      for (std::size_t b = 0; b < batches.size(); ++b) {
        Batch& batch = batches[b];
        const Wrench<Pack> wrench = energyOf().evaluate(b, packsOf(batch.p), packsOf(batch.psi), termOf(batch));
        put(wrench.n, batch.n), put(wrench.k, batch.k);
        LanesOf<1> energy;
        wrench.energy.store_aligned(energy[0].data());
        const std::size_t left = pairs().size() - b * std::size_t(pack_lanes);
        for (std::size_t lane = 0; lane < std::min(left, std::size_t(pack_lanes)); ++lane) sum += energy[0][lane];
      }
      return sum;
    } else {
      forEach(batches, [&](std::size_t i, Batch& batch, std::size_t lane) {
        const Wrench<double> wrench = energyOf().evaluate(i, batch.p.of(lane), batch.psi.of(lane), batch.termOf(lane));
        sum += wrench.energy;
        batch.n[0][lane] = wrench.n.x, batch.n[1][lane] = wrench.n.y, batch.n[2][lane] = wrench.n.z;
        batch.k[0][lane] = wrench.k.x, batch.k[1][lane] = wrench.k.y, batch.k[2][lane] = wrench.k.z;
      });
      return sum;
    }
  }
  void evaluateAll(const std::vector<Batch>& batches, std::vector<Slopes>& out) const final {
    if constexpr (in_packs) {
      for (std::size_t b = 0; b < batches.size(); ++b) {
        const Triple<Pack> p = packsOf(batches[b].p), psi = packsOf(batches[b].psi);
        const Wrench<PackJet> wrench = energyOf().evaluate(b, Triple<PackJet>{{p.x, 0}, {p.y, 1}, {p.z, 2}},
                                                           Triple<PackJet>{{psi.x, 3}, {psi.y, 4}, {psi.z, 5}}, termOf(batches[b]));
        putSlopes(wrench.n, out[b].n), putSlopes(wrench.k, out[b].k);
      }
    } else {
      forEach(batches, [&](std::size_t i, const Batch& batch, std::size_t lane) {
        const Triple<double> p = batch.p.of(lane), psi = batch.psi.of(lane);
        const Wrench<Jet> wrench = energyOf().evaluate(i, Triple<Jet>{{p.x, 0}, {p.y, 1}, {p.z, 2}},
                                                       Triple<Jet>{{psi.x, 3}, {psi.y, 4}, {psi.z, 5}}, batch.termOf(lane));
        Slopes& slopes = out[i / std::size_t(pack_lanes)];
        putSlopes(wrench.n, lane, slopes.n), putSlopes(wrench.k, lane, slopes.k);
      });
    }
  }
  static void putSlopes(const Triple<PackJet>& of, LanesOf<18>& out) {
    const PackJet* rows[3] = {&of.x, &of.y, &of.z};
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 6; ++k) rows[r]->slope[k].store_aligned(out[6 * r + k].data());
  }
  static void putSlopes(const Triple<Jet>& of, std::size_t lane, LanesOf<18>& out) {
    const Jet* rows[3] = {&of.x, &of.y, &of.z};
    for (std::size_t r = 0; r < 3; ++r)
      for (std::size_t k = 0; k < 6; ++k) out[6 * r + k][lane] = rows[r]->slope[Index(k)];
  }
};

}  // namespace stroma
