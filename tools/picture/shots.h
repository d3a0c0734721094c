// SPDX-License-Identifier: LGPL-2.1-or-later
// States of a simulation, as far as they are drawn: positions, the values that give the colours, what is held.
#pragma once
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/drawing/body.h"
#include "tools/picture/picture_maker.h"
#include "tools/picture/surface.h"
#include "tools/units/unit_system.h"

namespace stroma::picture {

/// A body at an instant, by page number.
struct BodyShot {
  Points x{};                           ///< of the surface's nodes, or of all when the body is cut [m]
  std::vector<float> values{};          ///< of these nodes, or of the cells; empty: the body has no such field
  std::vector<float> turns{};           ///< four for each rigid frame: its quaternion x y z w
  std::vector<Index> held{}, guided{};  ///< nodes that constraints act on
};

struct Shot {
  double time = 0;
  std::vector<BodyShot> bodies{};
  std::vector<Vec3> moved{};  ///< how far the obstacles of each component have come [m]
  std::size_t taker = 0;      ///< of which one: meshes may be others from one shot to the next
};

/// Where the values of a body are.
enum class ValuesAt { none, nodes, cells };

/// Takes shots. The field, and with it what is kept, is chosen once.
class ShotTaker {
 public:
  /// Throws ComponentError for a field that no body has, or a hidden node that there is not.
  ShotTaker(const Simulation& simulation, const PictureRequest& request);
  /// The same scene with other meshes, as `first` shows it. The components that are there now may be gone when the last shot of
  /// them has been taken; those of `first` stay. Throws std::runtime_error where that cannot be.
  ShotTaker(const Simulation& simulation, const ShotTaker& first);

  Shot take(double time);

  const drawing::Drawing& drawing() const { return drawing_; }
  bool isDrawn(std::size_t body) const { return drawn_[body]; }
  /// Those that are not hidden and not much larger than the bodies.
  bool isObstacleDrawn(std::size_t obstacle) const;
  const std::string& field() const { return field_; }  ///< its name; "none"
  /// Those below a node, by their numbers. Throws ComponentError with the nearest path when there are none, which are `to_be`
  /// hidden or framed.
  std::vector<std::size_t> bodiesAt(std::string path, const char* to_be) const;
  ValuesAt valuesAt(std::size_t body) const;
  /// That colours a body; null: none of cells, or of nodes that a component computes.
  const drawing::Field* fieldOf(std::size_t body) const;
  Points rest(std::size_t body) const;  ///< of as many nodes as the shots have [m]
  Vec3 restSize() const;                ///< of the box around what is drawn, at rest [m]
  /// Of the values that are seen in all shots so far: of stresses and the like from the lowest to the highest percentile but
  /// for one in a hundred at either end, as a few cells at a corner would leave all others in one colour.
  Range bulk() const { return bulk_; }
  Range extremes() const { return extremes_; }
  static std::vector<FieldWord> fieldsOf(const drawing::Drawing& drawing, const UnitSystem& units);
  const UnitSystem& units() const { return units_; }

 private:
  void keepOwn();
  void choose();
  void hide(const std::vector<std::string>& paths);
  void hideOneOfTwo();
  void hideOneOfTwo(const State& parent, const State& child);
  Index nodesOf(const drawing::Body& body) const;
  void addValues(std::size_t b, BodyShot& shot);
  void addCellValues(std::size_t b, BodyShot& shot);
  void measure(std::size_t b, const BodyShot& shot);
  std::vector<float> meansAtNodes(const drawing::Body& body) const;

  const Simulation& simulation_;
  const PictureRequest& request_;
  drawing::Drawing drawing_;
  std::vector<bool> drawn_, hidden_obstacles_;
  std::string field_;
  UnitSystem units_;  ///< of the scene
  std::vector<double> work_;
  std::vector<float> cell_values_;
  std::vector<Points> own_rest_;  ///< of what may go: what is drawn of it later
  std::vector<std::unique_ptr<const Mesh>> own_meshes_;
  std::optional<Vec3> own_size_;
  Range bulk_{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()}, extremes_ = bulk_;
};

/// The field for people: "von Mises stress".
std::string titleOf(const std::string& field);

}  // namespace stroma::picture
