// SPDX-License-Identifier: LGPL-2.1-or-later
// One cell of the stability matrix: a disturbed body steps until its ending is known.
#include <fmt/format.h>

#include <Eigen/Geometry>
#include <cmath>
#include <limits>
#include <map>
#include <random>

#include "tests/stability/matrix.h"
#include "tools/checks/result_doubts.h"

namespace stroma::test::matrix {

std::string wordOf(Ending ending) {
  static const char* words[] = {"recovered",    "stopped",   "under way", "rings, said", "kept, said",
                                "astray, said", "elsewhere", "moving",    "broken"};
  return words[int(ending)];
}

namespace {

/// Where an undisturbed body comes to rest, and the slowest of its small motions about that place [rad/s].
struct Rest {
  std::vector<Vec3> position;
  double slowest = 0;
};

class Run {
 public:
  Run(const Row& row, const IntegratorChoice& integrator, const Condition& condition, int most_steps)
      : row_(row),
        integrator_(integrator),
        condition_(condition),
        most_steps_(most_steps),
        slowest_(row.slowest(condition)),
        relaxation_(row.relaxation * condition.relaxationScale()) {}

  Outcome operator()() {
    const Rest& rest = reference();
    target_ = rest.position;
    slowest_ = rest.slowest;
    simulation_ = std::make_unique<Simulation>(sceneFromText(sceneText(integrator_.element, condition_.dt)));
    measure();
    energy_rest_ = restEnergy();
    disturb();
    energy_start_ = energy();
    // what neither rests nor stopped may only need more time; what comes nearer does
    for (int more = 0;; ++more) {
      const double before = distance();
      if (advance(limit())) return outcome_;
      settle();
      const bool nears = distance() < 0.999 * before;
      const bool moves = outcome_.ending == Ending::moving || outcome_.ending == Ending::astray;
      const bool comes = outcome_.ending == Ending::elsewhere || outcome_.ending == Ending::rings;
      if (!moves && !(comes && nears)) return outcome_;
      // slow decay of an amplitude that is told: not followed to its end. A sample of cells stops after 200 steps to save time, which
      // follows from nothing: what rings and grows later is seen by the whole matrix alone
      if (outcome_.ending == Ending::rings && outcome_.steps > std::min(2500, most_steps_ / 13)) return outcome_;
      const bool enough = nears && outcome_.steps + limit() > most_steps_;
      if (enough && (outcome_.ending == Ending::moving || outcome_.ending == Ending::elsewhere))
        outcome_.ending = Ending::under_way;
      const int patient = most_steps_ > 10'000 ? 3 : 1;  // of a sample of cells less is asked
      if (enough || outcome_.ending == Ending::under_way || (!nears && more >= patient)) return outcome_;
    }
  }

 private:
  std::string sceneText(const std::string& element, double dt) const {
    const double mass = std::min(2 * slowest_, 0.5 / dt);
    // a rule that damps nothing itself comes to rest only where the body does: by a viscosity that damps within some
    // steps what is faster than the step
    const double stiffness = integrator_.damps ? 0 : dt;
    Condition condition = condition_;
    condition.dt = dt;
    return row_.scene(
        fmt::format(fmt::runtime(element), fmt::format("rayleighMass='{}' rayleighStiffness='{}'", mass, stiffness)),
        condition);
  }

  /// Steps until the cell has ended (true) or `steps` are made, or as many failed one after the other as decide it.
  bool advance(int steps) {
    for (int step = 0, steady = 0, unsolved = 0; step < steps; ++step) {
      if (!one()) return true;
      unsolved = unsolved_.empty() ? 0 : unsolved + 1;
      if (unsolved >= patience()) return false;
      steady = distance() < 1e-6 ? steady + 1 : 0;
      if (steady < 5) continue;
      outcome_.steps -= 4;
      ended(Ending::recovered);
      return true;
    }
    return false;
  }

  /// A step; false when the cell has ended with it.
  bool one() {
    ++outcome_.steps;
    const StepReport report = simulation_->step();
    if (!finite())
      ended(Ending::broken, "a position or a velocity is not finite");
    else if (report.diverged)
      stop(report.reason);
    else {
      unsolved_ = report.unsolved ? report.reason : "";
      unconverged_ = report.newton_converged ? "" : report.reason;
      return true;
    }
    return false;
  }

  /// The same for all integrators and starts of a row, so it is kept.
  const Rest& reference() {
    static std::map<std::string, Rest> known;
    Rest& rest = known[fmt::format("{}|{}|{}", row_.name, condition_.young, condition_.poisson)];
    if (!rest.position.empty()) return rest;
    simulation_ = std::make_unique<Simulation>(sceneFromText(sceneText(integrators()[1].element, 0.5 / slowest_)));
    System& s = system();
    Vector before(s.allRows());
    for (int step = 0; step < 2000; ++step) {
      copy(s.x, before);
      simulation_->step();
      axpy(-1, s.x, before);
      if (std::sqrt(dot(before, before)) < 1e-13) break;
    }
    for (Index i = 0; i < s.allRows(); ++i) rest.position.push_back(s.x[i]);
    rest.slowest = slowestAt();
    return rest;
  }

  /// Of the small motions about the place of rest, by inverse iteration on K y = w^2 M y.
  double slowestAt() const {
    System& s = system();
    Vector y(s.independentRows()), momentum(s.independentRows());
    for (Index i = 0; i < s.independentRows(); ++i) y[i] = Vec3(std::sin(1 + i), std::cos(2 * i), std::sin(3 * i));
    s.constraints().project(y);
    double squared = 0;
    for (int iteration = 0; iteration < 12; ++iteration) {
      s.computeForce(s.x, s.v, s.f);
      clear(momentum);
      s.addMassProduct(y, 1, momentum);
      s.constraints().project(momentum);
      if (!s.linearSolver()->solve(s.matrix().withFactors({.stiffness = -1}), momentum, y).usable()) return slowest_;
      const double work = dot(y, momentum);
      clear(momentum);
      s.addMassProduct(y, 1, momentum);
      squared = work / dot(y, momentum);
      scale(1 / std::sqrt(dot(y, y)), y);
    }
    return squared > 1e-6 * slowest_ * slowest_ ? std::sqrt(squared) : slowest_;
  }

  void measure() {
    for (const Vec3& p : target_) box_.extend(p);
    size_ = box_.diagonal().norm();
  }
  System& system() const { return *simulation_->systems().at(0); }

  /// The map of the condition on what the constraints leave free.
  void disturb() {
    System& s = system();
    std::vector<Mat3> free(target_.size(), Mat3::Identity());
    for (const NodeProjector& held : s.constraints().projectors()) free[held.row] = held.projector;
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(0, 1);
    const Vec3 low = box_.min(), extent = box_.sizes(), centre = box_.center();
    for (std::size_t i = 0; i < target_.size(); ++i) {
      const double z = uniform(random), y = uniform(random), x = uniform(random);  // in this order with every compiler
      const Vec3 p = s.x[Index(i)], noise(x, y, z);
      Vec3 to = p;
      // an exact mirror image may balance on a saddle, which round-off alone would have to leave
      if (condition_.shape == "inverted") to = Vec3(2 * centre.x() - p.x(), p.y(), p.z()) + 1e-6 * size_ * noise;
      if (condition_.shape == "flat") to.z() = centre.z();
      if (condition_.shape == "line") to = Vec3(p.x(), centre.y(), centre.z());
      if (condition_.shape == "point") to = centre;
      if (condition_.shape == "random") to = low + extent.cwiseProduct(noise);
      if (condition_.shape == "pulled")
        to += 0.1 * size_ * Vec3(std::sin(7 * p.y() / size_), (p.z() - low.z()) / size_, std::cos(5 * p.x() / size_)) +
              0.02 * size_ * noise;
      s.x[Index(i)] += free[i] * (to - p);
    }
  }

  /// Equilibria that cannot be found, each by hundreds of iterations that go on from the best of the last step, are none later
  /// either: of 2,445 cells that were followed for 100 steps no one was. Stresses that relax may help; the whole matrix waits.
  int patience() const {
    if (!integrator_.iterates) return std::numeric_limits<int>::max();
    return std::max(relaxation_ == 0 ? 10 : 50, most_steps_ / 1000);
  }

  /// The slowest motion is critically damped: after 20 / slowest it is 4e-8 of what it was, and so is what relaxes.
  /// Where that takes too many steps a few show whether the energy grows.
  int limit() const {
    if (integrator_.is_static && relaxation_ == 0) return 100;
    const double needed = 20 * std::max(1 / slowest_, relaxation_) / condition_.dt;
    return needed > most_steps_ ? std::min(300, most_steps_ / 16) : std::max(200, int(needed));
  }
  // Loops over numbers: called after each step, and compiled without optimisation.
  bool finite() const {
    double sum = 0;
    for (const State* state : simulation_->states())
      for (const ConstRows rows : {ConstRows(state->x()), ConstRows(state->v())})
        for (const double *number = rows.data, *end = number + rows.doubles(); number != end; ++number)
          sum += *number - *number;  // not a number where it is not finite
    return sum == 0;
  }
  double distance() const {
    double largest = 0;
    const double* x = system().x.rows().data;
    for (std::size_t i = 0; i < target_.size(); ++i, x += row_doubles) {
      const double* target = target_[i].data();
      const double dx = x[0] - target[0], dy = x[1] - target[1], dz = x[2] - target[2];
      const double squared = dx * dx + dy * dy + dz * dz;
      if (squared > largest) largest = squared;
    }
    return std::sqrt(largest) / size_;
  }
  /// Above that of rest.
  double energy() const { return system().kineticEnergy() + system().potentialEnergy(system().x) - energy_rest_; }
  double restEnergy() const {
    Vector rest(system().allRows());
    for (Index i = 0; i < system().allRows(); ++i) rest[i] = target_[i];
    return system().potentialEnergy(rest);
  }
  int inverted() const {
    int count = 0;
    for (const ForceField* field : system().forceFields())
      for (const std::string& name : field->cellFields()) {
        std::vector<double> j;
        if (name != "J") continue;
        field->cellField("J", system().x, j);
        count += int(std::count_if(j.begin(), j.end(), [](double value) { return value <= 0; }));
      }
    return count;
  }

  void ended(Ending ending, const std::string& text = {}) {
    outcome_.ending = ending;
    outcome_.text = text;
    if (ending == Ending::elsewhere || ending == Ending::moving || ending == Ending::rings) {
      const auto doubts = doubtsOf(*simulation_);
      if (doubts.empty() && unconverged_.empty()) {
        if (ending == Ending::rings) outcome_.ending = Ending::moving;
      } else {
        if (ending == Ending::elsewhere) outcome_.ending = distance() < 3 ? Ending::kept : Ending::astray;
        if (ending == Ending::moving) outcome_.ending = Ending::astray;
        outcome_.text += (text.empty() ? "" : ". ") + (doubts.empty() ? unconverged_ : doubts[0]);
      }
    }
    outcome_.distance = distance();
    outcome_.inverted = inverted();
  }

  /// A stop must say which step, which component, which element where there are elements, and why.
  void stop(const std::string& reason) {
    std::vector<std::string> words{"/solver: ", fmt::format("step {} ", outcome_.steps)};
    for (const ForceField* field : system().forceFields())
      if (!field->worstElement(system().x).empty()) words.push_back(field->path());
    for (const std::string& word : words)
      if (reason.find(word) == std::string::npos)
        return ended(Ending::broken, fmt::format("no \"{}\" in: {}", word, reason));
    ended(Ending::stopped, reason);
  }

  /// Not at its shape after all steps: at rest elsewhere, too early to tell, or moving?
  void settle() {
    if (!unsolved_.empty()) return stop(unsolved_);
    System& s = system();
    double lowest = distance(), highest = lowest, shift = 0;
    Vector before(s.allRows());
    copy(s.x, before);
    for (int step = 0; step < 10; ++step) {
      if (!one()) return;
      const double now = distance();
      lowest = std::min(lowest, now), highest = std::max(highest, now);
      for (Index i = 0; i < s.allRows(); ++i) shift = std::max(shift, (s.x[i] - before[i]).norm() / size_);
    }
    if (!unsolved_.empty()) return stop(unsolved_);
    const double seconds = simulation_->time(), grown = energy() / energy_start_;
    const double speed = shift / std::max(10 * condition_.dt * slowest_, 1e-12);  // in sizes and slowest periods
    const bool relaxing = seconds < 20 * relaxation_;
    if ((integrator_.is_static || (speed < 1e-5 && shift < 1e-7)) && !relaxing) return ended(Ending::elsewhere);
    const std::string motion = fmt::format("moves by {:.1e} sizes, energy {:.1e} of the start", shift, grown);
    // what a force without a potential stores may grow while the body comes to rest
    const bool gained = grown > 1 + 1e-6 && (s.isConservative() || highest > 3);
    if (seconds * slowest_ < 20 || relaxing) return ended(gained ? Ending::moving : Ending::under_way, motion);
    const bool bounded = highest < 3 && grown < 10;
    ended(!integrator_.damps && bounded ? Ending::rings : Ending::moving, motion);
  }

  const Row& row_;
  const IntegratorChoice& integrator_;
  const Condition& condition_;
  const int most_steps_;
  double slowest_, relaxation_, size_ = 0, energy_start_ = 0, energy_rest_ = 0;
  std::unique_ptr<Simulation> simulation_;
  std::vector<Vec3> target_;
  Eigen::AlignedBox3d box_;
  std::string unsolved_, unconverged_;  ///< sentences of the last step
  Outcome outcome_;
};

}  // namespace

Outcome run(const Row& row, const IntegratorChoice& integrator, const Condition& condition, int most_steps) {
  return Run(row, integrator, condition, most_steps)();
}

}  // namespace stroma::test::matrix
