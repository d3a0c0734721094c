// SPDX-License-Identifier: LGPL-2.1-or-later
// Prony viscosity of any hyperelastic law: S_v = S_h - sum gamma_i (prony_series.h). In a step
//   S_v = (1 - sum a_i) S_h - H,   H = sum b_i gamma_i^{n-1} + sum c_i S_h^{n-1}
// where H does not depend on the shape at the step's end: the law's forces and tangent scaled, and those of a stress
// that is held. The tangent is the force's derivative exactly, and with H held the force has a potential. Where S_h is
// a part of a whole law S_w that relaxes alone, S_v = S_w - sum a_i S_h - H.
#pragma once
#include "components/hyperelasticity/prony_series.h"
#include "components/hyperelasticity/residual_stress.h"
#include "framework/scene/archive.h"

namespace stroma::hyperelastic {

class ViscousLaw final : public ElementKernels {
 public:
  /// `law`: method of `cells` under `description`, whose instantaneous response it is; `whole`: that of which it is a
  /// part, arranged in the same way, or null. Time starts at `start` [s].
  ViscousLaw(std::unique_ptr<ElementKernels> law, std::unique_ptr<ElementKernels> whole,
             const HyperelasticLaw& description, const Cells& cells, std::size_t cell_count, const PronySeries& series,
             std::unique_ptr<ResidualStress> held, double start);

  /// Forces from now on are those at time t [s]; x are the positions at that moment, read in the first step only.
  void setTime(double t, ConstRows x);
  /// The step to t ended at x: the history moves on.
  void stepEnded(double t, ConstRows x);
  /// gamma of each point and term, and with the exponential update S_h; shape (cells, points, terms (+ 1), 6) [Pa]
  const std::vector<double>& history() const { return history_; }
  /// See Component::serialize().
  void serialize(Archive& archive);
  /// Time restarts at `start`, without a history.
  void start(double start);
  /// S_h - sum gamma [Pa] at one point from F in the material's axes, at the time of the last setTime().
  Mat3 stress(std::size_t cell, std::size_t point, const Mat3& f) const;

  void addForce(ConstRows x, Rows f) override;
  void addForceAndProduct(ConstRows x, ConstRows dx, double factor, Rows f) override;
  double energy(ConstRows x) const override;
  void addProduct(ConstRows dx, double factor, Rows df) const override;
  /// Keeps what is held.
  bool refill() override {
    const bool law = law_->refill(), whole = !whole_ || whole_->refill();
    return law && whole;
  }
  void addPattern(BlockPattern& pattern) const override { law_->addPattern(pattern); }
  std::vector<Index> slots(const BlockMatrix& matrix) const override { return law_->slots(matrix); }
  void assemble(double factor, const std::vector<Index>& slots, std::vector<double>& values) const override;
  void assembleDiagonal(double factor, std::vector<double>& blocks) const override;

 private:
  std::size_t stored() const { return series_.terms() + (series_.update == PronyUpdate::exponential ? 1 : 0); }
  void prepare(double t);
  void elasticStresses(ConstRows x);

  /// What the law's forces are multiplied by: its share, of which a whole law has one already.
  double factor() const { return whole_ ? share_ - 1 : share_; }

  std::unique_ptr<ElementKernels> law_, whole_;
  std::unique_ptr<ResidualStress> held_;
  const HyperelasticLaw& description_;
  std::function<Values(std::size_t)> parameters_;
  PronySeries series_;
  std::vector<PronyStep> step_;  ///< shape (terms), of the time of the last setTime()
  std::size_t cells_, points_;
  double time_ = 0;       ///< [s], of the history
  double prepared_ = 0;   ///< [s], the time of what is held; NaN: none
  double share_ = 1;      ///< 1 - sum a_i
  bool started_ = false;  ///< S_h at the start is known
  std::vector<double> history_, stress_, elastic_, deformation_;
  Vector force_;
};

}  // namespace stroma::hyperelastic
