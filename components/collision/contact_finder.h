// SPDX-License-Identifier: LGPL-2.1-or-later
// Where a CollisionResponse gets its contacts from: contact_pairs.h, or with sofaLists what SOFA would list, in its order.
//
// With sofaLists parts are compared by SOFA's formulas (listed_parts.h), pair of models after pair:
//   1. Models are taken in the order of the scene, a node's own before those of its children. Each is paired with itself, where it
//      has selfCollision, and then with those before it. A pair needs boxes that are nearer than the alarm distance.
//   2. The first of a pair is the one whose kind comes first: triangles, lines, spheres, points; of the same kind the later one. Pairs of
//      parts come in the order of the models' trees (halving_tree.h), which are those of the first step.
//   3. Penalties keep one contact of each number, the nearest. Friction drops contacts whose two points are those of one before, within
//      1e-4 m in the root of the sum of squares, and pairs with a contactStiffness of zero.
//   4. Pairs of models are sorted by the numbers of their first and then their second model. SOFA gives a model its number when its map of
//      pairs first compares it; the search and the response have a map each. Within a comparison the order is that of GCC: the second
//      model of the left pair, its first, then those of the right pair. Clang begins with the right pair.
//   5. Contacts of a pair belong to the root, or to the node of the other model where one is not simulated. Nodes come in the order of the
//      scene.
//
// Source: SOFA's BruteForceBroadPhase, BVHNarrowPhase, NarrowPhaseDetection, CollisionResponse, BaseUnilateralContactResponse,
// BarycentricPenalityContact.
#pragma once
#include <map>
#include <memory>
#include <set>

#include "components/collision/contact_rules.h"
#include "components/collision/halving_tree.h"
#include "components/collision/listed_parts.h"

namespace stroma {
class Archive;
}

namespace stroma::collision {

class ContactFinder {
 public:
  void declare(DataTable& table);
  void compile(const Node& root, const std::vector<ModelPair>& pairs, const Method& method, const ContactRules& rules);
  void find(std::vector<Contact>& out);
  bool lists() const { return lists_; }
  /// With sofaLists, of a contact found last: the place of its node in the scene, a name of its pair of models since these touch, and its
  /// number in the pair (in the first search, the complement).
  void addName(std::size_t contact, std::vector<int>& out) const { out.insert(out.end(), names_[contact].begin(), names_[contact].end()); }
  void reset();
  void serialize(Archive& archive);

 private:
  using Key = std::pair<Index, Index>;  ///< two of surfaces_
  /// Numbers of surfaces in the order in which they are compared; -1: not yet.
  struct Numbers {
    std::vector<Index> of;
    Index next = 0;
    Index operator()(Index surface);
  };
  struct Before {
    std::shared_ptr<Numbers> numbers;
    bool operator()(const Key& a, const Key& b) const;
  };
  struct Surface {
    const CollisionModel* model = nullptr;
    HalvingTree tree{};
    std::vector<Box> boxes{};
    NormalCones cones{};
    std::vector<std::vector<Index>> neighbours{};  ///< of each node by the model's edges, where it may meet its own node's models
    std::vector<Index> order{};                    ///< of a checkpoint
    bool is_moved = true;
  };
  struct Pair {
    Key models;
    bool is_of_one_node = false;
    const Node* node = nullptr;
    Answer answer{};
  };
  using Found = std::map<Key, std::vector<Listed>, Before>;
  Index surfaceOf(const CollisionModel& model);
  void fitAll();
  bool mayMeet(const Surface& a, Index i, const Surface& b, Index j) const;
  void look(const Pair& pair);
  void update();
  static void keepNearest(std::vector<Listed>& contacts);
  static void dropDoubles(std::vector<Listed>& contacts);
  void serializeKeys(Archive& archive, const char* name, std::vector<Key>& keys) const;

  bool lists_ = false;
  int depth_ = 6;
  ContactSearch search_;
  const Method* method_ = nullptr;
  std::vector<Surface> surfaces_;
  std::vector<Pair> pairs_;
  std::map<Key, std::size_t> pair_of_;
  std::map<const Node*, Index> place_of_;  ///< of nodes, in the order of the scene
  std::shared_ptr<Numbers> found_numbers_, answered_numbers_;
  std::unique_ptr<Found> found_;
  std::unique_ptr<std::set<Key, Before>> answered_;
  std::vector<std::array<int, 3>> names_;
  std::map<Key, int> begun_;  ///< of the pairs in answered_: the number of the search that found their first contacts
  int searches_ = 0;
  bool has_trees_ = false;
};

}  // namespace stroma::collision
