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
  const std::vector<Mapping*>& mappings = actors.mappings;
  loads_.assign(mappings.size(), {});
  for (std::size_t i = mappings.size(); i-- > 0;) {
    State* const child = &mappings[i]->output();
    const auto has = [child](const std::vector<State*>& states) { return std::ranges::count(states, child) > 0; };
    for (const ForceField* field : actors.force_fields)
      if (has(field->states())) loads_[i].push_back(field);
    for (std::size_t j = i + 1; j < mappings.size(); ++j)
      if (has(mappings[j]->inputs())) loads_[i].insert(loads_[i].end(), loads_[j].begin(), loads_[j].end());
    const bool has_mass = std::ranges::any_of(actors.masses, [&](const Mass* m) { return has({&m->state()}); });
    if (has_mass) loads_[i].push_back(nullptr);  // of what is only looked at products know no force
  }
}

ConstRows MappingChain::positions(ConstRows x) const {
  if (empty()) return x;
  copy(x.head(actors_->independent_rows), x_.head(actors_->independent_rows));
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->apply(x_);
  return std::as_const(x_).rows();
}

ConstRows MappingChain::beginProduct(ConstRows p) const {
  acting_.clear();
  for (std::size_t i = 0; i < loads_.size(); ++i)
    if (std::ranges::any_of(loads_[i], [](const ForceField* field) { return !field || field->acts(); }))
      acting_.push_back(actors_->mappings[i]);
  return acting_.empty() ? p : lifted(p, p_, acting_);
}

ConstRows MappingChain::lifted(ConstRows p, Vector& work, const std::vector<Mapping*>& mappings) const {
  if (empty()) return p;
  copy(p.head(actors_->independent_rows), work.head(actors_->independent_rows));
  for (const Mapping* mapping : mappings) heard("map", mapping)->applyJ(work);
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
  if (acting_.empty()) return out;
  clear(f_);
  return f_;
}

void MappingChain::finishProduct(ConstRows p, double k, Rows all, Rows out) const {
  if (acting_.empty()) return;
  for (auto mapping = acting_.rbegin(); mapping != acting_.rend(); ++mapping) {
    if (k != 0 && !(*mapping)->isLinear()) (*mapping)->addGeometricProduct(last_force_, p, k, all);
    heard("map", *mapping)->applyJT(all);
  }
  axpy(1, all.head(actors_->independent_rows), out.head(actors_->independent_rows));
}

void MappingChain::pullBack(Rows all) const {
  for (auto mapping = actors_->mappings.rbegin(); mapping != actors_->mappings.rend(); ++mapping)
    if (const Rows f = (*mapping)->output().segment(all); std::any_of(f.data, f.data + f.doubles(), [](double v) { return v != 0; }))
      heard("map", *mapping)->applyJT(all);
}

void MappingChain::noteForce(ConstRows f) {
  const Index first = actors_->independent_rows, count = f.count - first;  // of these are geometric stiffnesses
  if (!linear_) copy(f.segment(first, count), last_force_.rows().segment(first, count));
}

void MappingChain::place(Rows x, Rows v) const {
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->apply(x);
  for (const Mapping* mapping : actors_->mappings) heard("map", mapping)->applyJ(v);
}

void MappingChain::placePassive(Rows x, Rows v) const {
  ++passive_placings_;
  for (const Mapping* mapping : actors_->passive_mappings) heard("map", mapping)->apply(x);
  for (const Mapping* mapping : actors_->passive_mappings) heard("map", mapping)->applyJ(v);
}

}  // namespace stroma
