// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/collision/contact_finder.h"

#include <algorithm>

#include "framework/scene/archive.h"
#include "framework/scene/node.h"

namespace stroma::collision {

namespace {

void number(const Node& node, std::map<const Node*, Index>& places) {
  places.emplace(&node, Index(places.size()));
  for (const auto& child : node.children()) number(*child, places);
}

Vec3 pointOf(const CollisionModel& model, const PartPoint& point) {
  Vec3 place = Vec3::Zero();
  for (int i = 0; i < point.part->corners; ++i) place += point.weight[std::size_t(i)] * model.place(point.part->node[std::size_t(i)]);
  return place;
}

bool holds(const std::vector<Index>& list, Index value) { return std::find(list.begin(), list.end(), value) != list.end(); }

}  // namespace

Index ContactFinder::Numbers::operator()(Index surface) {
  Index& number = of[std::size_t(surface)];
  if (number < 0) number = next++;
  return number;
}

bool ContactFinder::Before::operator()(const Key& a, const Key& b) const {
  Numbers& number = *numbers;
  const Index a_second = number(a.second), a_first = number(a.first), b_second = number(b.second), b_first = number(b.first);
  return Key(a_first, a_second) < Key(b_first, b_second);
}

void ContactFinder::declare(DataTable& table) {
  table.add("sofaLists", lists_)
      .help("contacts are those that SOFA lists, by its formulas and in its order; friction then counts slides from where bodies touch");
  table.add("treeDepth", depth_).help("with sofaLists: how often the trees of boxes are cut, the depth of SOFA's CollisionPipeline").min(0);
}

Index ContactFinder::surfaceOf(const CollisionModel& model) {
  for (std::size_t i = 0; i < surfaces_.size(); ++i)
    if (surfaces_[i].model == &model) return Index(i);
  surfaces_.emplace_back();
  Surface& added = surfaces_.back();
  added.model = &model, added.is_moved = model.isMoved() || model.isMoving();
  added.boxes.resize(model.parts().size());
  if (method_->hasCones()) added.cones.compile(model, method_->angleCone(), method_->coneFactor());
  return Index(surfaces_.size() - 1);
}

void ContactFinder::compile(const Node& root, const std::vector<ModelPair>& pairs, const Method& method, const ContactRules& rules) {
  method_ = &method;
  if (!lists_) return search_.compile(pairs, method);
  surfaces_.clear(), pairs_.clear(), pair_of_.clear(), place_of_.clear();
  number(root, place_of_);
  for (const ModelPair& pair : pairs) {
    const Index a = surfaceOf(*pair.a), b = surfaceOf(*pair.b);
    const bool keeps = placeInPair(pair.a->kind()) < placeInPair(pair.b->kind());
    const Node* node = !pair.a->isSimulated() ? &pair.b->node() : !pair.b->isSimulated() ? &pair.a->node() : &root;
    pairs_.push_back({keeps ? Key(a, b) : Key(b, a), &pair.a->node() == &pair.b->node(), node, rules.of(*pair.a, *pair.b)});
    if (!pairs_.back().is_of_one_node) continue;
    for (const Index each : {a, b}) {
      Surface& surface = surfaces_[std::size_t(each)];
      if (!surface.neighbours.empty()) continue;
      surface.neighbours.resize(std::size_t(surface.model->state().nodes()));
      for (const Edge& edge : surface.model->edges())
        for (int k = 0; k < 2; ++k)
          surface.neighbours[std::size_t(edge[std::size_t(k)])].push_back(edge[std::size_t(1 - k)]);
    }
  }
  // a model meets itself before those that stand above it: pairs of one later model follow each other
  for (std::size_t begin = 0, end = 0; begin < pairs.size(); begin = end) {
    while (end < pairs.size() && pairs[end].b == pairs[begin].b) ++end;
    std::stable_partition(pairs_.begin() + long(begin), pairs_.begin() + long(end),
                          [](const Pair& pair) { return pair.models.first == pair.models.second; });
  }
  for (std::size_t i = 0; i < pairs_.size(); ++i) pair_of_[pairs_[i].models] = i;
  reset();
}

void ContactFinder::reset() {
  has_trees_ = false;
  for (Surface& surface : surfaces_) surface.order.clear();
  for (auto* numbers : {&found_numbers_, &answered_numbers_}) {
    *numbers = std::make_shared<Numbers>();
    (*numbers)->of.assign(surfaces_.size(), -1);
  }
  found_ = std::make_unique<Found>(Before{found_numbers_});
  answered_ = std::make_unique<std::set<Key, Before>>(Before{answered_numbers_});
  names_.clear(), begun_.clear();
  searches_ = 0;
}

void ContactFinder::fitAll() {
  for (Surface& surface : surfaces_) {
    if (has_trees_ && !surface.is_moved) continue;
    surface.model->boxParts(surface.boxes, surface.model->contactDistance());
    if (has_trees_)
      surface.tree.refit(surface.boxes);
    else if (surface.order.size() == surface.boxes.size())
      surface.tree.build(surface.boxes, depth_, surface.order);
    else
      surface.tree.build(surface.boxes, depth_);
  }
  has_trees_ = true;
}

/// Of models of one node: not what shares a node with its neighbours, and of points and spheres each two once.
bool ContactFinder::mayMeet(const Surface& a, Index i, const Surface& b, Index j) const {
  using Kind = CollisionModel::Kind;
  const Kind first = a.model->kind(), second = b.model->kind();
  const Part &p = a.model->parts()[std::size_t(i)], &q = b.model->parts()[std::size_t(j)];
  if (first == Kind::triangle && second == Kind::point) return std::find(p.node.begin(), p.node.end(), q.node[0]) == p.node.end();
  if (first == Kind::sphere) return a.model != b.model || i > j;
  if (first == Kind::triangle || second == Kind::sphere) return true;
  if (first == Kind::point) {
    if (a.model != b.model) return true;
    if (i <= j) return false;
    const auto &of_i = a.neighbours[std::size_t(i)], &of_j = a.neighbours[std::size_t(j)];
    return !holds(of_i, j) && std::none_of(of_i.begin(), of_i.end(), [&](Index each) { return holds(of_j, each); });
  }
  if (second == Kind::line && a.model != b.model) return true;
  for (int k = 0; k < 2; ++k)
    for (int l = 0; l < q.corners; ++l) {
      const Index u = p.node[std::size_t(k)], w = q.node[std::size_t(l)];
      if (u == w || holds(a.neighbours[std::size_t(u)], w)) return false;
    }
  return true;
}

void ContactFinder::look(const Pair& pair) {
  const Surface &a = surfaces_[std::size_t(pair.models.first)], &b = surfaces_[std::size_t(pair.models.second)];
  if (a.tree.empty() || b.tree.empty() || !a.tree.whole().isNear(b.tree.whole(), method_->alarmDistance())) return;
  std::vector<Listed>& out = found_->emplace_hint(found_->end(), pair.models, std::vector<Listed>())->second;
  const PartLister lister(*method_, *a.model, *b.model, a.cones, b.cones);
  a.tree.forEachPair(b.tree, method_->alarmDistance(), [&](Index i, Index j) {
    if (!pair.is_of_one_node || mayMeet(a, i, b, j)) lister.meet(i, j, out);
  });
}

/// Of those with one number the first of the nearest, in its place.
void ContactFinder::keepNearest(std::vector<Listed>& contacts) {
  std::map<long, std::size_t> best;
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const auto [at, is_new] = best.emplace(contacts[i].number, i);
    if (!is_new && contacts[i].value < contacts[at->second].value) at->second = i;
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < contacts.size(); ++i)
    if (best.at(contacts[i].number) == i) contacts[kept++] = contacts[i];
  contacts.erase(contacts.begin() + long(kept), contacts.end());
}

void ContactFinder::dropDoubles(std::vector<Listed>& contacts) {
  constexpr double same = 1e-8;  // [m^2]
  std::vector<std::pair<Vec3, Vec3>> places;
  std::size_t kept = 0;
  for (const Listed& each : contacts) {
    const Contact& contact = each.contact;
    const Vec3 p = pointOf(*contact.model_a, contact.a), q = pointOf(*contact.model_b, contact.b);
    const auto isHere = [&](const auto& place) { return (place.first - p).squaredNorm() + (place.second - q).squaredNorm() < same; };
    if (std::any_of(places.begin(), places.end(), isHere)) continue;
    places.emplace_back(p, q);
    contacts[kept++] = each;
  }
  contacts.erase(contacts.begin() + long(kept), contacts.end());
}

/// Which pairs have contacts, as SOFA's two maps of pairs know it.
void ContactFinder::update() {
  for (auto& each : *found_) each.second.clear();
  for (const Pair& pair : pairs_) look(pair);
  std::erase_if(*found_, [](const auto& each) { return each.second.empty(); });
  for (const auto& each : *found_) answered_->insert(each.first);
  std::erase_if(*answered_, [this](const Key& key) { return !found_->contains(key); });
  std::erase_if(begun_, [this](const auto& each) { return !found_->contains(each.first); });
  for (const Key& key : *answered_) begun_.emplace(key, searches_);
}

void ContactFinder::find(std::vector<Contact>& out) {
  if (!lists_) return search_.find(out);
  out.clear(), names_.clear();
  ++searches_;
  fitAll();
  update();
  std::vector<const Pair*> pairs;
  for (const Key& key : *answered_) pairs.push_back(&pairs_[pair_of_.at(key)]);
  std::stable_sort(pairs.begin(), pairs.end(),
                   [this](const Pair* a, const Pair* b) { return place_of_.at(a->node) < place_of_.at(b->node); });
  for (const Pair* pair : pairs) {
    std::vector<Listed> contacts = found_->at(pair->models);
    const auto stiffness = [this](Index surface) { return surfaces_[std::size_t(surface)].model->contactStiffness(); };
    if (pair->answer.rubs && (stiffness(pair->models.first) == 0 || stiffness(pair->models.second) == 0)) continue;
    pair->answer.rubs ? dropDoubles(contacts) : keepNearest(contacts);
    const int begun = begun_.at(pair->models), place = place_of_.at(pair->node);
    for (const Listed& each : contacts) {
      const int number = int(each.number);
      out.push_back(each.contact);
      names_.push_back({place, begun * int(pairs_.size()) + int(pair - pairs_.data()), begun == searches_ ? ~number : number});
    }
  }
}

void ContactFinder::serializeKeys(Archive& archive, const char* name, std::vector<Key>& keys) const {
  std::vector<Index> numbers;
  for (const Key& key : keys) numbers.push_back(key.first), numbers.push_back(key.second);
  archive.list(name, numbers);
  keys.clear();
  for (std::size_t i = 0; i + 1 < numbers.size(); i += 2) keys.emplace_back(numbers[i], numbers[i + 1]);
}

void ContactFinder::serialize(Archive& archive) {
  if (!lists_) return;
  if (!found_) reset();  // not compiled: nothing can touch
  std::vector<Key> found, answered(answered_->begin(), answered_->end());
  for (const auto& each : *found_) found.push_back(each.first);
  std::vector<Index> orders;
  if (has_trees_ && !archive.isReading())
    for (const Surface& surface : surfaces_)
      for (const Index item : surface.tree.order()) orders.push_back(item);
  if (archive.isReading()) reset();
  archive.list("orders_of_trees", orders);
  for (const auto& [name, numbers] : {std::pair("numbers_found", found_numbers_), std::pair("numbers_answered", answered_numbers_)}) {
    archive.list(name, numbers->of);
    numbers->next = Index(std::count_if(numbers->of.begin(), numbers->of.end(), [](Index each) { return each >= 0; }));
  }
  std::vector<int> begun;
  for (const Key& key : answered) begun.push_back(begun_.count(key) ? begun_.at(key) : 0);
  archive.value("searches", searches_), archive.list("begun", begun);
  serializeKeys(archive, "pairs_found", found), serializeKeys(archive, "pairs_answered", answered);
  if (!archive.isReading()) return;
  if (found_numbers_->of.size() != surfaces_.size()) return reset();  // written where nothing could touch
  for (const Key& key : found) found_->emplace_hint(found_->end(), key, std::vector<Listed>());
  for (std::size_t i = 0; i < answered.size(); ++i) answered_->insert(answered[i]), begun_[answered[i]] = begun[i];
  std::size_t at = 0;
  for (Surface& surface : surfaces_) {
    const std::size_t count = surface.boxes.size();
    if (at + count > orders.size()) continue;
    surface.order.assign(orders.begin() + long(at), orders.begin() + long(at + count));
    at += count;
  }
}

}  // namespace stroma::collision
