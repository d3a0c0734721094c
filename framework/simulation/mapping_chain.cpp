// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/simulation/mapping_chain.h"

#include <algorithm>
#include <utility>

#include "framework/scene/spans.h"

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
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->apply(x_);
  return std::as_const(x_).rows();
}

ConstRows MappingChain::lifted(ConstRows p, Vector& work) const {
  if (empty()) return p;
  copy(p.head(actors_->independent_rows), work.head(actors_->independent_rows));
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->applyJ(work);
  return std::as_const(work).rows();
}

void MappingChain::curve(ConstRows v, Rows a) const {
  clear(a);
  for (const Mapping* mapping : actors_->mappings) {
    heard("map", mapping)->applyJ(a);
    if (!mapping->isLinear()) mapping->addCurvature(v, a);
  }
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
    heard("map", *mapping)->applyJT(all);
}

void MappingChain::pullBackProduct(ConstRows p, double k, Rows all) const {
  for (auto mapping = actors_->mappings.rbegin(); mapping != actors_->mappings.rend(); ++mapping) {
    if (!(*mapping)->isLinear()) (*mapping)->addGeometricProduct(last_force_, p, k, all);
    heard("map", *mapping)->applyJT(all);
  }
}

void MappingChain::noteForce(ConstRows f) {
  if (!linear_) copy(f, last_force_);
}

void MappingChain::place(Rows x, Rows v) const {
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->apply(x);
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->applyJ(v);
}

void MappingChain::placePassive(Rows x, Rows v) const {
  for (const Mapping* mapping : actors_->passive_mappings) heard("map", mapping)->apply(x);
  for (const Mapping* mapping : actors_->passive_mappings) heard("map", mapping)->applyJ(v);
}

}  // namespace stroma
