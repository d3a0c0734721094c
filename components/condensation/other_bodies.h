// SPDX-License-Identifier: LGPL-2.1-or-later
// The bodies in the system of a condensed solver that are not condensed: rigid frames, soft bodies below another integrator, and what is
// mapped onto them. They move by backward Euler, with forces linearised once per step:
//
//   A dv = h P (f + h K v - alpha M v),   A = P (M (1 + h alpha) - h C - h^2 K) P + (1 - P),   v' = v + dv,   x' = x + h v'
//
// with the projector P of constraints. Without springs on frames this is what Newton's method gives in EulerImplicitSolver. Rows that no
// term of A couples form clusters. That of a frame has a small inverse: W = J A^-1 J^T of a constraint between a frame and a condensed body
// is the sum of a 6 x 6 product and of entries of the stored inverse. A soft body has the linear solver of its integrator, which solves for
// the columns of A^-1 of nodes that constraints may load. The inertia of a frame rotates with it: the linear solve finds its angular
// momentum L, and w' follows from J(exp(h w') q) w' = L.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "framework/mechanics/frames.h"
#include "framework/simulation/assembled_matrix.h"
#include "framework/simulation/integrator.h"
#include "framework/simulation/system.h"

namespace stroma {

class OtherBodies {
 public:
  /// Finds them: frames, and what is mapped from frames alone. Throws ComponentError for forces and masses that it does not support.
  /// `rayleigh_mass`: of the condensed solver, which damps them too [1/s].
  void collect(System& system, const Integrator& integrator, double rayleigh_mass);
  bool empty() const { return rows_.empty(); }
  bool has(const State& state) const;
  bool has(const Component& component) const;  ///< a force field, mass or mapping that acts on them
  /// Their rows, mapped ones included.
  bool hasRow(Index row) const { return !is_other_.empty() && is_other_[std::size_t(row)]; }
  bool hasConstraints() const { return has_constraints_; }
  bool turns() const { return !blocks_.empty() || !turning_.empty(); }
  /// The inputs on them have changed.
  void inputsChanged() { inputs_changed_ = true; }

  // ---- for steps; an independent row of theirs has a number k < count() ----
  Index count() const { return Index(rows_.size()); }
  /// Stores where the step starts.
  void keep(const System& system);
  /// Moves them to where no constraint force acts, after System::beginStep() if they have constraints. Returns false if A is singular.
  bool begin(System& system, const StepContext& context);
  /// Why the last begin() or solveColumns() failed.
  const std::string& fault() const { return fault_; }
  bool wasStopped() const { return solved_.stop == SolveStop::stopped; }
  /// Adds what the linear solves of the step were.
  void addTo(StepReport& report) const;
  /// Back to where the step started.
  void restore(System& system) const;
  /// Calls visit(k, gradient) for each row that a gradient on `row` acts on, through mappings, projected. Rows of soft bodies are visited
  /// with a gradient of zero too.
  template <class Visit>
  void pull(Index row, const Vec3& gradient, Visit&& visit);
  /// h^2 P A^-1 P between two rows [m/N]: their displacement by a force that acts during the step. Zero between rows of a soft body that
  /// nothing loads.
  Mat3 compliance(Index k, Index l) const;
  /// A constraint may load row k in this step.
  void load(Index k);
  /// Solves for what rows loaded since the last call need, which lastLoads() then lists. False if a solve fails, see fault().
  bool solveColumns();
  const std::vector<Index>& lastLoads() const { return last_loads_; }
  Vec3 free(Index k) const { return h_ * (start_velocity_[std::size_t(k)] + free_change_[std::size_t(k)]); }
  /// The displacement of row k that `linear`, the one of the linear solve, becomes with the inertia at the end of the step.
  Vec3 turned(Index k, const Vec3& linear) const;
  /// The present displacement since the start of the step.
  const Vec3& now(Index k) const { return now_[std::size_t(k)]; }
  void place(System& system, Index k, const Vec3& displacement);
  /// After place(): the points mapped onto them.
  void placeMapped(System& system);
  /// Ends the step with these forces of constraints, shape (count()) [N]. Returns false if a velocity is not finite.
  bool finish(System& system, const std::vector<Vec3>& forces);
  /// A run begins again: nothing is known of matrices.
  void reset();
  /// Writes or reads what the linear solvers of soft bodies remember.
  void serialize(Archive& archive);
  std::string describe() const;

 private:
  class Matrix;
  struct Cluster {
    std::vector<Index> rows;  ///< k
    Eigen::MatrixXd inverse;  ///< of a small one
    std::shared_ptr<Matrix> matrix;  ///< of a large one
    LinearSolver* solver = nullptr;
    std::map<Index, std::array<Vector, 3>> columns;  ///< of A^-1 P, by k
  };
  struct Turning {
    Mat3 inertia = Mat3::Zero();  ///< in body axes [kg m^2]
    bool turns = true;
  };
  struct Place {
    std::size_t begin = 0, end = 0;  ///< of order_
  };
  void collectStates(System& system);
  void collectActing(System& system, const Integrator& integrator);
  void refuseMixed(const Component& component, const std::vector<State*>& states, const Integrator& integrator) const;
  void checkHeld(const System& system, const Integrator& integrator) const;
  void collectMappings();
  void collectTurning();
  void compileFields(System& system);
  void computeForce(System& system);
  void findClusters();
  void makeClusters(const System& system);
  bool invert(System& system);
  void invertSmall(Cluster& cluster, const BlockMatrix* matrix) const;
  void checkSolvers() const;
  bool isSymmetric() const;
  void makeLarge(const System& system, Cluster& cluster) const;
  void takeValues(Cluster& cluster, const BlockMatrix& matrix) const;
  bool solve(Cluster& cluster, const std::vector<ConstRows>& right, const std::vector<Rows>& solutions);
  bool findFreeChange(Cluster& cluster);
  Mat3 massBlock(Index k) const;
  Mat3 projector(const System& system, Index k) const;
  void updateJacobians();
  Vec3 velocity(Index k, const Vec3& change) const;
  bool isHeld(Index k) const { return projectors_[std::size_t(k)].isZero(0); }

  std::vector<char> is_other_;       ///< shape (all rows); empty: there are none
  std::vector<const State*> states_;  ///< mapped ones included
  std::vector<Index> rows_, number_;  ///< row of k; k of an independent row
  std::vector<ForceField*> fields_;
  std::vector<Mass*> masses_;
  std::vector<Mapping*> mappings_;
  bool has_constraints_ = false, is_static_ = false, has_inertia_turns_ = false;

  Actors actors_;  ///< of these bodies alone
  MappingChain chain_;
  std::unique_ptr<AssembledMatrix> assembled_;  ///< null: only masses
  long pattern_ = -1;
  bool inputs_changed_ = true, has_inputs_ = false, is_inverted_ = false;
  std::vector<Cluster> clusters_;
  std::vector<std::size_t> cluster_of_;  ///< of k, with its place there
  std::vector<Index> place_in_;
  bool has_large_ = false;
  std::vector<char> loads_;  ///< of k: loaded in this step; empty without large clusters
  std::vector<Index> new_loads_, last_loads_;
  std::vector<std::vector<Index>> pushed_;  ///< rows of each cluster; work space
  std::string fault_;
  StopToken stop_;      ///< of the step
  SolveReport solved_;  ///< of all linear solves of the step
  std::vector<std::pair<const State*, LinearSolver*>> solvers_;  ///< of soft bodies

  std::vector<std::vector<JacobianBlock>> blocks_;  ///< of each mapping
  std::vector<std::array<std::size_t, 2>> order_;   ///< mapping and block, by child row
  std::vector<Place> of_row_;                       ///< of a mapped row
  bool outdated_ = true;

  std::vector<Turning> turning_;
  std::vector<int> turning_of_;  ///< of k, or -1

  double h_ = 0, rayleigh_mass_ = 0;
  Vector force_;                 ///< shape (all rows)
  std::vector<Vec3> gravity_, kept_velocity_, start_velocity_, free_change_, now_;  ///< start_velocity_: with prescribed ones
  std::vector<Quaternion> start_turn_;
  std::vector<std::array<double, row_doubles>> start_;
  std::vector<Mat3> projectors_;
};

template <class Visit>
void OtherBodies::pull(Index row, const Vec3& gradient, Visit&& visit) {
  const bool is_zero = gradient.isZero(0);
  if (is_zero && !has_large_) return;
  if (std::size_t(row) < number_.size()) {
    const Index k = number_[std::size_t(row)];
    const Vec3 along = projectors_[std::size_t(k)] * gradient;
    if (!along.isZero(0) || (clusters_[cluster_of_[std::size_t(k)]].matrix && !isHeld(k))) visit(k, along);
    return;
  }
  if (outdated_) updateJacobians();
  const Place place = of_row_[std::size_t(row) - number_.size()];
  for (std::size_t i = place.begin; i < place.end; ++i) {
    const JacobianBlock& block = blocks_[order_[i][0]][order_[i][1]];
    pull(block.parent, block.block.transpose() * gradient, visit);
  }
}

}  // namespace stroma
