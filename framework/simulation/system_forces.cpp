// SPDX-License-Identifier: LGPL-2.1-or-later
// The forces on the unknowns of a system, the products of their derivatives, and energies.
#include <algorithm>
#include <cassert>

#include "framework/scene/node.h"
#include "framework/scene/spans.h"
#include "framework/simulation/system.h"

namespace stroma {

void System::setTime(double t) {
  for (ForceField* field : actors_.timed_fields) field->setTime(t);
}

void System::computeGravity() {
  gravity_force_.resize(allRows());
  for (const Mass* mass : masses()) {
    if (mass->node().gravity().isZero(0)) continue;
    mass->addGravity(gravity_force_);
    has_gravity_ = true;
  }
  if (has_gravity_) ++counts.gravity;
  curved_masses_.clear();
  for (Mass* mass : masses())
    if (!mappings_.isLinear() && mass->state().firstRow() >= independentRows()) curved_masses_.push_back(mass);
  for (Vector* vector : {&curve_, &momentum_}) vector->resize(hasCurvedInertia() ? allRows() : 0);
}

void System::noteForceEvaluation(ConstRows f_now) {
  ++counts.forces;
  mappings_.noteForce(f_now);
  if (actors_.derivatives_vary) ++derivatives_revision_;
}

void System::updateMasses(ConstRows x_all) const {
  for (Mass* mass : actors_.masses)
    if (mass->turns()) mass->update(x_all);
}

/// f -= M a, a as MappingChain::curve() has it, and of turning inertia w x J w.
void System::addCurvedInertia(ConstRows v_all, Rows f_now) const {
  mappings_.curve(v_all, curve_);
  for (const Mass* mass : curved_masses_) {
    mass->addProduct(curve_, -1, f_now);
    if (!mass->turns()) continue;
    clear(momentum_);
    mass->addProduct(v_all, 1, momentum_);
    for (const TurningInertia& turning : mass->turningInertias())
      if (const Index row = mass->state().firstRow() + turning.row; turning.turns) f_now[row] -= v_all[row].cross(momentum_[row]);
  }
}

void System::startForce(Rows out) const {
  if (has_gravity_)
    copy(gravity_force_, out);
  else
    clear(out);
}

void System::computeForce(ConstRows x_now, ConstRows v_now, Rows f_now) {
  const PhaseTimer timer(times.force);
  assert(f_now.count == allRows());
  const ConstRows x_all = mappings_.positions(x_now), v_all = mappings_.velocities(v_now);
  updateMasses(x_all);
  startForce(f_now);
  for (ForceField* field : forceFields()) heard("force", field)->addForce(x_all, v_all, f_now);
  if (hasCurvedInertia()) addCurvedInertia(v_all, f_now);
  mappings_.pullBack(f_now);
  noteForceEvaluation(f_now);
}

void System::computeRequestedForce(double t) {
  if (std::none_of(states().begin(), states().end(), [](const State* s) { return s->forceRequested(); })) return;
  setTime(t);
  computeForce(x, v, f);
}

void System::computeForceAndProduct(ConstRows x_now, ConstRows v_now, ConstRows p, const MatrixFactors& factors, Rows out) {
  const bool is_needed = !mappings_.isLinear();  // by the geometric stiffness of mappings
  if (is_needed || keeps_force_) computeForce(x_now, v_now, f);
  if (is_needed) {
    copy(f, out);
    addStiffnessProduct(p, factors, independent(out));
    return;
  }
  // in one pass whether the force is kept alone or not: its last bits are others than those of two
  const PhaseTimer timer(times.force);
  assert(out.count == allRows());
  const ConstRows x_all = mappings_.positions(x_now), v_all = mappings_.velocities(v_now);
  const ConstRows p_all = mappings_.direction(p);
  updateMasses(x_all);
  startForce(out);
  for (ForceField* field : forceFields()) {
    const double factor = factors.of(*field);
    if (factor == 0 || !field->traits().has_stiffness) {
      heard("force", field)->addForce(x_all, v_all, out);
    } else {
      heard("force", field)->addForceAndProduct(x_all, v_all, p_all, factor, out);
    }
  }
  mappings_.pullBack(out);
  noteForceEvaluation(out);
}

// ---- products ----

void System::addStiffnessProduct(ConstRows p, const MatrixFactors& factors, Rows out) const {
  const PhaseTimer timer(times.product);
  const ConstRows p_all = mappings_.beginProduct(p);
  const Rows all = mappings_.beginSum(out);
  for (const ForceField* field : actors_.stiff_fields)
    if (const double factor = factors.of(*field); factor != 0) heard("product", field)->addStiffnessProduct(p_all, factor, all);
  mappings_.finishProduct(p_all, factors.stiffness, all, out);
}

template <class Factor>
void System::addMassProducts(ConstRows p, Rows out, Factor factor) const {
  const ConstRows p_all = mappings_.beginProduct(p);
  const Rows all = mappings_.beginSum(out);
  for (const Mass* mass : masses())
    if (factor(*mass) != 0) heard("product", mass)->addProduct(p_all, factor(*mass), all);
  mappings_.finishProduct(p_all, 0, all, out);
}

void System::addMassProduct(ConstRows p, double factor, Rows out) const {
  addMassProducts(p, out, [factor](const Mass&) { return factor; });
}

void System::addRayleighMassProduct(ConstRows p, double rayleigh, double factor, Rows out) const {
  addMassProducts(p, out, [=](const Mass& mass) { return (rayleigh + mass.rayleigh_mass) * factor; });
}

// ---- energies ----

double System::kineticEnergy(ConstRows v_then) const {
  updateMasses(x);
  double sum = 0;
  for (const Mass* mass : masses()) sum += mass->kineticEnergy(v_then);
  return sum;
}

double System::elasticEnergy(ConstRows x_now) const {
  const ConstRows all = mappings_.positions(x_now);
  double sum = 0;
  for (const ForceField* field : forceFields()) sum += field->energy(all);
  return sum;
}

double System::gravityEnergy(ConstRows x_now) const {
  if (!has_gravity_) return 0;
  const ConstRows all = mappings_.positions(x_now);
  double sum = 0;
  for (const Mass* mass : masses()) sum += mass->gravityEnergy(all);
  return sum;
}

bool System::isConservative() const {
  return std::all_of(forceFields().begin(), forceFields().end(), [](const ForceField* field) { return field->traits().conservative; });
}

}  // namespace stroma
