// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "components/collision/collision_method.h"
#include "components/collision/normal_cones.h"

namespace stroma::collision {

/// A point of a part of a surface: sum weight_i x_i over its corners.
struct PartPoint {
  const Part* part = nullptr;
  std::array<double, 3> weight{};
};

/// Two points of two surfaces that were closer than the alarm distance at the last search for contacts.
struct Contact {
  const CollisionModel *model_a, *model_b;
  PartPoint a, b;
  Vec3 normal;    ///< unit, from a to b
  double contact; ///< distance of the two points at which surfaces touch, radii and skins included [m]
};

/// Contacts of pairs of models at the models' current positions. As in SOFA, points and lines and triangles have contacts
/// where the closest points lie within both, more than 1e-6 of their size from the ends; a triangle and a line or a triangle
/// by the corners, of which each belongs to one part, and by edges where the method says so. A part that lands on the edge
/// between two triangles, without a line there, touches one of them: in SOFA it falls through. A LocalMinDistance checks the
/// cones of both parts. Where the method says so, a sphere is also tested against the edges and corners of triangles, except
/// those of a triangle, a line or a point that it touches anyway.
///
/// A method that follows paths has a contact of two parts also if they come as near as the contact distance on their paths. Its points
/// and normal are those of the moment when they do.
///
/// Where two models have no contact, a lower bound of the distances of their parts less the alarm distance is computed: the
/// clearance of the pair. No distance decreases by more than the difference of their displacements since then, so that the
/// pair is skipped until that difference reaches the clearance. The result of a search at the models' current positions is
/// the same with and without it.
class ContactSearch {
 public:
  void compile(const std::vector<ModelPair>& pairs, const Method& method);
  void find(std::vector<Contact>& out);

 private:
  struct Surface {
    const CollisionModel* model;
    std::size_t body;  ///< number of its state
    std::vector<Box> boxes;
    BoxTree tree;
    NormalCones cones;
    bool is_fit = false;  ///< boxes are those of now
  };
  /// The nodes of a state that are corners of models.
  struct Body {
    const State* state;
    std::vector<Index> rows{};
    std::vector<Vec3> from{};  ///< where they were when rooms were found [m]
    Box gone{};                ///< of their displacements since then [m]
    double size = 0;           ///< largest coordinate there [m]
    bool is_known = false;     ///< all of these are numbers
    void follow();
    void startHere();
    Vec3 place(std::size_t node) const;
  };
  struct Pair {
    std::size_t a, b;
    double alarm = 0, contact = 0;  ///< [m], with the skins of both
    double room = -1;               ///< [m]; below zero: not known
    double used = 0, motion = 0;    ///< up to Body::from, and up to now [m]
    int steps = 0;                  ///< since it was looked at
  };
  std::size_t surfaceOf(const CollisionModel& model);
  std::size_t bodyOf(const CollisionModel& model);
  void follow(Pair& pair) const;
  static bool hasRoom(const Pair& pair) { return pair.motion < pair.room; }
  void findRoom(Pair& pair, double in_a_step) const;
  void look(Pair& pair, std::vector<Contact>& out);
  /// Not two neighbours of one state.
  static bool mayMeet(const CollisionModel& a, const Part& p, const CollisionModel& b, const Part& q, double contact);
  void ready(Surface& surface) const;
  bool meetOnPath(const Surface& a, const Part& p, const Surface& b, const Part& q, double contact, std::vector<Contact>& out) const;
  void meet(const Surface& a, const Part& p, const Surface& b, const Part& q, double alarm, double contact,
            std::vector<Contact>& out) const;

  const Method* method_ = nullptr;
  std::vector<Surface> surfaces_;
  std::vector<Body> bodies_;
  std::vector<Pair> pairs_;
};

}  // namespace stroma::collision
