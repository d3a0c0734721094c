// SPDX-License-Identifier: LGPL-2.1-or-later
// The stability matrix: rows (every force field of the factory, with every method), columns (every implicit integrator,
// linearised and with Newton's method) and conditions (bad starting shapes, extreme moduli and steps).
#pragma once
#include <algorithm>
#include <cmath>
#include <functional>
#include <regex>
#include <string>
#include <vector>

#include "tests/support/scene_fixture.h"

namespace stroma::test::matrix {

/// Made once for each pattern: making it takes longer than using it.
const std::regex& compiled(const std::string& pattern);

struct Condition {
  std::string name, shape = "pulled";
  double young = 5000, poisson = 0.4, dt = 0.01;
  /// What relaxes does so faster in stiffer bodies, as their motions are faster.
  double relaxationScale() const { return std::min(1.0, std::sqrt(5000 / young)); }
};
const std::vector<Condition>& conditions();

struct IntegratorChoice {
  std::string name, element;  ///< {} takes the attributes of Rayleigh damping
  bool damps = true;          ///< fast motions, with no help of the scene
  bool is_static = false;
  bool iterates = false;  ///< statics, until its tolerance is met
};
const std::vector<IntegratorChoice>& integrators();

/// A force field on a body that has a rest shape.
struct Row {
  std::string name, type;
  /// The scene for an integrator's text and a condition; no gravity.
  std::function<std::string(const std::string& integrator, const Condition&)> scene;
  /// Angular frequency of the slowest motion [rad/s], not too large.
  std::function<double(const Condition&)> slowest;
  bool has_poisson = false;
  bool is_alias = false;  ///< another name of a component that has its rows already
  double relaxation = 0;  ///< [s], of the slowest stress or pressure that relaxes, at a scale of 1
  bool is_large = false;  ///< its body has four times as many nodes as others
};
const std::vector<Row>& rows();

/// How a cell of the matrix ends.
enum class Ending {
  recovered,  ///< at its rest shape, within 1e-6 of its size, and it stays there
  stopped,    ///< with a sentence; nothing that is not finite in a state
  under_way,  ///< the time simulated is too short to tell; the energy has not grown
  rings,      ///< bounded around its shape by an integrator that damps nothing, which Simulation::doubts() says
  kept,       ///< at rest in another shape, which they or the last step's report say
  astray,     ///< moving, growing or far away, which they say
  elsewhere,  ///< at rest in another equilibrium with no element inverted, in silence
  moving,     ///< none of these, in silence
  broken      ///< a number that is not finite, or a stop without a sentence: a defect
};
std::string wordOf(Ending ending);

struct Outcome {
  Ending ending = Ending::broken;
  int steps = 0;
  double distance = 0;  ///< of the worst node from its place, in sizes of the body
  int inverted = 0;     ///< elements with J <= 0 at the end
  std::string text;     ///< the sentence of a stop; what is wrong
};
/// A cell that needs more than about `most_steps` is given up as under way.
Outcome run(const Row& row, const IntegratorChoice& integrator, const Condition& condition, int most_steps);

}  // namespace stroma::test::matrix
