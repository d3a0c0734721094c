// SPDX-License-Identifier: LGPL-2.1-or-later
// The cases of a scene: what is done to it in each. A number and a seed make a case again.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "tools/stress/targets.h"

namespace stroma::stress {

struct Reach;

enum class Kind {
  forces,      ///< forces against energies, derivatives and mappings, at a shape
  shape,       ///< the nodes are put elsewhere, or get velocities
  move,        ///< what is held jumps, and jumps back
  attribute,   ///< a number of the scene is another one
  not_finite,  ///< a NaN comes in
  threads,     ///< the same bits are expected
  memory       ///< less than the scene takes
};

/// How nodes are put elsewhere.
enum class Shape { small, pulled, cell, mirrored, flat, line, point, random, stretched, kicked };

/// Where a NaN, or an infinity, comes in.
enum class Entry { attribute, infinite_attribute, position, velocity, force, edit };

struct Case {
  long number = 0;
  Kind kind = Kind::forces;
  std::string group;  ///< its line of the table
  std::string text;   ///< what is done, in words
  unsigned seed = 1;  ///< of what is chosen at random in it
  Shape shape = Shape::small;
  Entry entry = Entry::attribute;
  double amount = 0;                 ///< sizes of the body; threads; MB
  std::optional<Override> override;  ///< of the scene
};

/// Those of a loaded scene, most telling first. The list ends; beyond its end magnitudes are taken at random.
class CaseList {
 public:
  CaseList(const Simulation& simulation, unsigned seed);
  long size() const { return long(cases_.size()); }
  Case at(long number) const;

 private:
  void addForces(const Reach& reach);
  void addShapes(const Reach& reach);
  void addMoves();
  void addEntries(const Simulation& simulation, const Reach& reach);
  void addAttributes(std::size_t round);
  void add(Case one);

  unsigned seed_;
  std::vector<Target> targets_;
  std::vector<Case> cases_;
};

}  // namespace stroma::stress
