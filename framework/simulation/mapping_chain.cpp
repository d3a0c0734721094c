// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/mapping_chain.h"

#include <algorithm>
#include <utility>

namespace stroma {

void MappingChain::compile(const Actors& actors) {
  actors_ = &actors;
  if (empty()) return;
  for (Vector* vector : {&x_, &v_, &p_, &f_}) vector->resize(actors.all_rows);
  linear_ = std::all_of(actors.mappings.begin(), actors.mappings.end(), [](const Mapping* m) { return m->isLinear(); });
  if (!linear_) last_force_.resize(actors.all_rows);
}

ConstRows MappingChain::positions(ConstRows x) const {
  if (empty()) return x;
  copy(x.head(actors_->independent_rows), x_.head(actors_->independent_rows));
  for (const Mapping* mapping : actors_->mappings) mapping->apply(x_);
  return std::as_const(x_).rows();
}

ConstRows MappingChain::lifted(ConstRows p, Vector& work) const {
  if (empty()) return p;
  copy(p.head(actors_->independent_rows), work.head(actors_->independent_rows));
  for (const Mapping* mapping : actors_->mappings) mapping->applyJ(work);
  return std::as_const(work).rows();
}

void MappingChain::curve(ConstRows x, ConstRows v, Rows a) const {
  const double time = 1e-4 / (1 + largest(v.head(actors_->independent_rows)));
  clear(a);
  for (const double sign : {1., -1.}) {
    copy(x.head(actors_->independent_rows), x_.head(actors_->independent_rows));
    actors_->motion.advance(sign * time, v.head(actors_->independent_rows), x_);
    for (const Mapping* mapping : actors_->mappings) mapping->apply(x_);
    axpy(sign / (2 * time), velocities(v), a);
  }
  clear(a.head(actors_->independent_rows));
  positions(x);
  velocities(v);
}

Rows MappingChain::beginSum(Rows out) const {
  if (empty()) return out;
  clear(f_);
  return f_;
}

void MappingChain::finishSum(Rows all, Rows out) const {
  if (empty()) return;
  pullBack(all);
  axpy(1, all.head(actors_->independent_rows), out.head(actors_->independent_rows));
}

void MappingChain::finishProduct(ConstRows p, double k, Rows all, Rows out) const {
  if (empty()) return;
  pullBackProduct(p, k, all);
  axpy(1, all.head(actors_->independent_rows), out.head(actors_->independent_rows));
}

void MappingChain::pullBack(Rows all) const {
  for (auto mapping = actors_->mappings.rbegin(); mapping != actors_->mappings.rend(); ++mapping)
    (*mapping)->applyJT(all);
}

void MappingChain::pullBackProduct(ConstRows p, double k, Rows all) const {
  for (auto mapping = actors_->mappings.rbegin(); mapping != actors_->mappings.rend(); ++mapping) {
    if (!(*mapping)->isLinear()) (*mapping)->addGeometricProduct(last_force_, p, k, all);
    (*mapping)->applyJT(all);
  }
}

void MappingChain::noteForce(ConstRows f) {
  if (!linear_) copy(f, last_force_);
}

void MappingChain::place(Rows x, Rows v) const {
  for (const Mapping* mapping : actors_->mappings) mapping->apply(x);
  for (const Mapping* mapping : actors_->mappings) mapping->applyJ(v);
}

void MappingChain::placePassive(Rows x, Rows v) const {
  for (const Mapping* mapping : actors_->passive_mappings) mapping->apply(x);
  for (const Mapping* mapping : actors_->passive_mappings) mapping->applyJ(v);
}

}  // namespace stroma
