// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/hyperelasticity/viscous_law.h"

#include <Eigen/LU>
#include <algorithm>
#include <limits>
#include <stdexcept>

namespace stroma::hyperelastic {
namespace {

constexpr std::size_t symmetric = 6;
constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

/// S = F^-1 P. A point that is exactly flat has no F^-1: NaN, as everywhere in a law with J in a denominator.
void secondStress(const Mat3& f, const Mat3& p, double* out) {
  const Mat3 s = f.inverse() * p;
  const double v[symmetric] = {s(0, 0), s(1, 1), s(2, 2), s(0, 1), s(1, 2), s(2, 0)};
  std::copy(v, v + symmetric, out);
}

}  // namespace

ResidualStressKernels& residualStressKernels() {
  static ResidualStressKernels kernels;
  return kernels;
}

ViscousLaw::ViscousLaw(std::unique_ptr<ElementKernels> law, std::unique_ptr<ElementKernels> whole,
                       const HyperelasticLaw& description, const Cells& cells, std::size_t cell_count,
                       const PronySeries& series, std::unique_ptr<ResidualStress> held, double start_time)
    : law_(std::move(law)),
      whole_(std::move(whole)),
      held_(std::move(held)),
      description_(description),
      parameters_(cells.parameters),
      series_(series),
      step_(series.terms()),
      cells_(cell_count) {
  Vector rest(cells.first_row + Index(cells.rest->size()));
  for (std::size_t i = 0; i < cells.rest->size(); ++i) rest[cells.first_row + Index(i)] = (*cells.rest)[i];
  held_->deformations(rest, deformation_);
  points_ = deformation_.size() / (9 * cells_);
  stress_.resize(cells_ * points_ * symmetric);
  elastic_.resize(stress_.size());
  start(start_time);
}

void ViscousLaw::start(double time) {
  history_.assign(cells_ * points_ * stored() * symmetric, 0.);
  started_ = false;
  time_ = time;
  prepared_ = nothing;
  prepare(time);
}

void ViscousLaw::serialize(Archive& archive) {
  archive.value("time", time_);
  archive.value("started", started_);
  archive.rows("history", history_.data(), history_.size());
  if (!archive.isReading()) return;
  prepared_ = nothing;
  prepare(time_);
}

/// a, b, c of the steps from the history's time to t, the law's share and what is held.
void ViscousLaw::prepare(double t) {
  if (t == prepared_) return;
  prepared_ = t;
  const std::size_t terms = series_.terms();
  share_ = 1;
  double before = 0;
  for (std::size_t i = 0; i < terms; ++i) {
    step_[i] = pronyStep(series_.update, series_.alpha[i], series_.tau[i], std::max(0., t - time_));
    share_ -= step_[i].now, before += step_[i].before;
  }
  const double* from = history_.data();
  for (std::size_t p = 0; p < cells_ * points_; ++p, from += stored() * symmetric)
    for (std::size_t k = 0; k < symmetric; ++k) {
      double sum = 0;
      for (std::size_t i = 0; i < terms; ++i) sum += step_[i].kept * from[i * symmetric + k];
      if (stored() > terms) sum += before * from[terms * symmetric + k];
      stress_[p * symmetric + k] = sum;
    }
  held_->hold(stress_);
}

void ViscousLaw::setTime(double t, ConstRows x) {
  if (!started_ && t > time_) {  // the first step: x is where it starts
    started_ = true;
    if (stored() > series_.terms()) {
      elasticStresses(x);
      for (std::size_t p = 0; p < cells_ * points_; ++p)
        std::copy_n(&elastic_[p * symmetric], symmetric, &history_[(p * stored() + series_.terms()) * symmetric]);
    }
  }
  prepare(t);
}

void ViscousLaw::elasticStresses(ConstRows x) {
  held_->deformations(x, deformation_);
  for (std::size_t p = 0; p < cells_ * points_; ++p) {
    const Mat3 f = Eigen::Map<const Mat3>(&deformation_[9 * p]);
    secondStress(f, description_.stress(parameters_(p / points_), f), &elastic_[p * symmetric]);
  }
}

void ViscousLaw::stepEnded(double t, ConstRows x) {
  elasticStresses(x);
  const std::size_t terms = series_.terms();
  for (std::size_t i = 0; i < terms; ++i)
    step_[i] = pronyStep(series_.update, series_.alpha[i], series_.tau[i], std::max(0., t - time_));
  double* gamma = history_.data();
  for (std::size_t p = 0; p < cells_ * points_; ++p, gamma += stored() * symmetric) {
    const double* now = &elastic_[p * symmetric];
    double* last = stored() > terms ? gamma + terms * symmetric : nullptr;
    for (std::size_t i = 0; i < terms; ++i)
      for (std::size_t k = 0; k < symmetric; ++k) {
        double& value = gamma[i * symmetric + k];
        value = step_[i].now * now[k] + step_[i].kept * value + (last ? step_[i].before * last[k] : 0);
      }
    if (last) std::copy_n(now, symmetric, last);
  }
  // what is held stays: with the same positions it gives S_h - sum gamma of the new history
  time_ = t;
  prepared_ = nothing;
  started_ = true;
}

Mat3 ViscousLaw::stress(std::size_t cell, std::size_t point, const Mat3& f) const {
  double s[symmetric];
  secondStress(f, description_.stress(parameters_(cell), f), s);
  const double* h = &stress_[(cell * points_ + point) * symmetric];
  for (std::size_t k = 0; k < symmetric; ++k) s[k] = share_ * s[k] - h[k];
  Mat3 out;
  out << s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2];
  return out;
}

// ---- forces: the share of the law's and what a whole law has besides, minus what is held ----

void ViscousLaw::addForce(ConstRows x, Rows f) {
  if (force_.count() != x.count) force_.resize(x.count);
  clear(force_);
  law_->addForce(x, force_);
  axpy(factor(), force_, f);
  if (whole_) whole_->addForce(x, f);
  held_->forces().addProduct(x, -1, f);
}
void ViscousLaw::addForceAndProduct(ConstRows x, ConstRows dx, double scale, Rows f) {
  if (force_.count() != x.count) force_.resize(x.count);
  clear(force_);
  law_->addForceAndProduct(x, dx, scale, force_);
  axpy(factor(), force_, f);
  if (whole_) whole_->addForceAndProduct(x, dx, scale, f);
  held_->forces().addProduct(x, -1, f);
  held_->forces().addProduct(dx, -scale, f);
}
double ViscousLaw::energy(ConstRows x) const {
  return factor() * law_->energy(x) + (whole_ ? whole_->energy(x) : 0) - held_->forces().energy(x);
}
void ViscousLaw::addProduct(ConstRows dx, double scale, Rows df) const {
  law_->addProduct(dx, factor() * scale, df);
  if (whole_) whole_->addProduct(dx, scale, df);
  held_->forces().addProduct(dx, -scale, df);
}
void ViscousLaw::assemble(double scale, const std::vector<Index>& slots, std::vector<double>& values) const {
  law_->assemble(factor() * scale, slots, values);
  if (whole_) whole_->assemble(scale, slots, values);
  held_->forces().assemble(-scale, slots, values);
}
void ViscousLaw::assembleDiagonal(double scale, std::vector<double>& blocks) const {
  law_->assembleDiagonal(factor() * scale, blocks);
  if (whole_) whole_->assembleDiagonal(scale, blocks);
  held_->forces().assembleDiagonal(-scale, blocks);
}

}  // namespace stroma::hyperelastic
