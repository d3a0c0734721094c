// SPDX-License-Identifier: LGPL-2.1-or-later
// What the condensed solvers share: precomputation, its cache on disk, nodes moved by position or pulled by a hand,
// Lagrangian constraints, the interior on demand and the range of linear elasticity.
#pragma once
#include <Eigen/Dense>
#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "components/condensation/compliance.h"
#include "components/condensation/condensed_body.h"
#include "components/condensation/condensed_conditions.h"
#include "components/condensation/condensed_contact.h"
#include "components/condensation/linear_range.h"
#include "components/condensation/other_bodies.h"
#include "components/condensation/partial_cholesky.h"
#include "components/condensation/section_file.h"
#include "framework/algebra/memory.h"
#include "framework/simulation/integrator.h"

namespace stroma {

/// u_S = C f*_S with C = (A^-1)_SS, A the matrix of a static or of a dynamic step. Active nodes are those of u: the
/// kept ones, or every free node where the inside is solved for in each step. Vectors over them have 3 numbers per node
/// and are padded to chunks of 8.
class CondensedIntegrator : public Integrator, public StateOwner, public FindsMultipliers, public RespectsStepLimits {
 public:
  void declare(DataTable& table) override;
  void compile(System& system) final;
  StateOwner* stateOwner() final { return this; }
  void checkInputOn(const State& state, const Input& input) const final;
  void sceneChanged() final { hands_changed_ = true, others_.inputsChanged(); }
  bool respectsStepLimits() const final { return true; }
  void stepTaken(const StepContext& context) final;
  void complete(System& system) final;
  std::string doubt() const final;
  void reset() override;
  void serialize(Archive& archive) override;

  /// Digest of the sources that make the numbers of a file: it belongs to the key.
  static std::string sourcesOfNumbers();

 protected:
  /// How u follows from f: C of the kept nodes by columns, or by half of it; a sweep through the factor of the inside
  /// before and after half of C; the sparse factor of every node.
  enum class Form { columns, symmetric, joined, factor };
  enum class Precision : int { double_precision, single_precision };
  /// A direction in which a node is moved by position, or pulled by a spring.
  struct Touch {
    Index node = 0;  ///< active
    Vec3 direction = Vec3::Zero();
    double stiffness = 0;  ///< of the spring [N/m]; 0: moved by position
    bool operator==(const Touch&) const = default;
  };
  /// Forces of inputs on one node, projected; that of a pull is not known before touches are solved for.
  struct Hand {
    Index node = 0;  ///< active
    Vec3 force = Vec3::Zero();
  };

  virtual bool isDynamic() const = 0;
  /// Dynamic: damping by the mass [1/s].
  virtual double rayleighMass() const { return 0; }
  /// Dynamic: masses of inside nodes are in the matrix.
  virtual bool keepsInteriorMass() const { return false; }
  /// Dynamic: masses of inside nodes go to the kept ones.
  virtual bool sharesInteriorMass() const { return false; }
  /// The form that the matrix should have; `factor` only where every node is kept.
  virtual Form form() const = 0;
  /// True when `symmetric` may replace `factor` where it is measured to be faster.
  virtual bool mayInvert() const { return false; }
  /// Where mayInvert(): a product with half of an inverse of `rows` rows, as steps do it, whose numbers do not matter.
  virtual std::function<void()> trialProduct(std::size_t) const { return {}; }
  virtual std::unique_ptr<PartialCholesky> makeFactor() const = 0;
  /// Refuses attributes that contradict each other.
  virtual void checkChoices() const {}
  /// After compile(): allocate.
  virtual void prepare(System& system) = 0;
  virtual std::string stepText() const = 0;
  /// columns(k) = C times direction k, shape (padded); for touches.
  virtual void complianceOf(const Touch& touch, double* column) = 0;
  /// Rows of node i and columns of node j of C.
  virtual Mat3 complianceBlock(Index i, Index j) = 0;
  /// u += C f, f on some nodes.
  virtual void addResponse(const std::vector<Index>& nodes, const std::vector<std::array<double, 3>>& forces,
                           double* u) = 0;
  /// SupernodalColumns::forward and backward, compiled for the machine.
  virtual void forward(double* y) = 0;
  virtual void backward(double* y) = 0;
  std::string describe() const final;

  // ---- for steps ----
  /// Prescribed motion at the end of the step: x of the moved nodes has it, touches() says what it means. Inputs:
  /// hands() and further touches.
  void moveTouched(System& system, const StepContext& context);
  /// After moveTouched(): empty, or why the reactions or the motion of other bodies cannot be solved for.
  const OtherBodies& others() const { return others_; }
  const std::string& touchFault() const { return others_fault_.empty() ? touch_fault_ : others_fault_; }
  /// Takes moveTouched() back.
  void restoreTouched(System& system);
  const std::vector<Touch>& touches() const { return touches_; }
  std::size_t moved() const { return moved_.size(); }  ///< touches before those of pulls
  std::vector<Hand>& hands() { return hands_; }        ///< one per node, ascending
  Hand& handOn(Index node);
  /// lambda = (E^T C E + S)^-1 (wanted - E^T u), u the displacement without it; S = diag(1/stiffness), 0 for moved
  /// nodes; shape (touches).
  const Eigen::VectorXd& solveTouches(const double* u);
  const Eigen::MatrixXd& touchColumns() const { return touch_columns_; }  ///< C E, shape (padded, touches)
  bool hasConditions() const { return !conditions_.constraints.empty(); }
  /// u, the displacement that all else leads to, gets that of the forces of Lagrangian constraints. False: the step
  /// is to be given up, and x is what it was.
  bool holdConditions(System& system, Array<double>& u, StopToken stop, StepReport& report);
  bool changeConditions(const System& system);
  bool hasContact() const { return !contact_.fields.empty(); }
  /// The same for the forces of barriers.
  bool holdContact(System& system, Array<double>& u, StopToken stop, StepReport& report);
  /// Forces on inside nodes that change in time, reduced to kept ones: active f changes by out.
  bool reduceTimedInterior(double* out);
  /// Writes x = x_0 + u, and v where it is given, into the rows of active nodes, and ends the step of other bodies; false, and nothing
  /// written into active rows, when a number is not finite.
  bool writeActive(System& system, const double* u, const double* v);
  /// The end of a step: outputs, forces when somebody asked.
  void finish(System& system);
  StepReport failure(const std::string& reason) const;

  /// Every free node is active, the inside too.
  bool insideIsActive() const { return used_form_ == Form::factor || used_form_ == Form::joined; }
  /// Steps leave the inside behind.
  bool leavesInside() const { return !insideIsActive() && body_.interior() > 0; }
  Index active() const { return active_; }
  Index firstActive() const { return first_active_; }
  std::size_t padded() const { return chunksOf(3 * std::size_t(active_)) * lanes; }
  Index activeRow(Index node) const { return active_rows_[node]; }
  const void* compliance() const { return compliance_; }
  bool isSingle() const { return precision_ == Precision::single_precision; }
  const Array<double>& origin() const { return origin_; }                 ///< x_0 of active nodes, shape (padded)
  const Array<double>& constantForce() const { return constant_force_; }  ///< reduced to active nodes, shape (padded)
  const std::vector<double>& inertia() const { return inertia_; }         ///< masses of active nodes, shape (active, 3)
  const std::vector<double>& massDamping() const { return damping_; }     ///< alpha [1/s], shape (active)
  double timeStep() const { return dt_; }
  CondensedBody body_;
  Form used_form_ = Form::columns;
  SupernodalColumns eliminated_;
  Array<double> sweep_work_;
  bool condensed_ = true;
  Array<double> base_;  ///< what prepare() makes of C and the constant loads; empty: it has to

 private:
  struct Problem;
  /// Of one solve, where both forms were allowed. Also a section of a file: numbers alone.
  struct Measured {
    double sweeps = 0;   ///< through the sparse factor [s]; 0: nothing was measured
    double product = 0;  ///< with the inverse [s]; at least, when it was not multiplied as a whole
    double rows = 0;     ///< of what was multiplied; 0: the inverse does not fit into memory
  };
  ContentKey keyOf(const Problem& problem) const;
  void computeFaster(Problem& problem);
  void computeAnew(Problem& problem);
  void measureForms();
  bool inverseFits() const;
  bool inverseIsFaster() const;
  static std::map<std::array<std::uint64_t, 2>, Measured>& remembered();
  bool recallForms(const ContentKey& key);
  void rememberForms(const ContentKey& key) const;
  std::string measuredText() const;
  double memoryLimit() const;
  bool loadStored(Problem& problem);
  bool inverseIsIntact(const Problem& problem) const;
  void store(const Problem& problem);
  void refuseTooLarge(double bytes, const std::string& what) const;
  void shareInteriorMass(const Problem& problem, PartialCholesky& factor);
  void packInverse(PartialCholesky& factor, const std::function<void(double)>& progress);
  void useStored(Problem& problem);
  void checkFactor();
  void sweepConstantForce();
  void prepareActive(System& system, const std::vector<Index>& order, const std::vector<double>& force);
  static bool isPull(const Touch& touch) { return touch.stiffness > 0; }
  static void addDirections(Index node, const Mat3& projector, double stiffness, std::vector<Touch>& to);
  bool findMoved(const System& system);
  void compileTouches();
  void weigh(Eigen::MatrixXd& small);
  void factorTouches(const Eigen::MatrixXd& small);
  bool findHands(const System& system);
  void gatherHands(const System& system);
  double pullStiffness(const Input& input) const;
  void compileConditions(System& system);
  void beginConditions(System& system, const StepContext& context, bool is_told);
  std::string findConditions(const System& system);
  void readCompliance(std::size_t known);
  void prepareSlots(const System& system, const double* u);
  void couple();
  double respond();
  void placeSlots(System& system);
  double addOther(Index row, const Vec3& gradient, std::size_t first, bool is_live);
  void readColumns();
  void giveForces();
  void addForces(Array<double>& u);
  std::string nameOfCondition(std::size_t row) const;
  std::string nodesOfCondition(const System& system, std::size_t row) const;
  void judgeConditions(const System& system, double step, double size, StepReport& report);
  void compileContact(System& system);
  void pushAt(System& system, const Array<double>& u);
  void assembleContact(const System& system);
  std::string findTouched(const System& system);
  void findPush();
  void findWay();
  double slopeOnWay(double part) const;
  void goOnWay(System& system, double part);
  double searchWay(System& system, double slope, double longest);
  bool correctContact(System& system, StepReport& report);
  std::string cacheFolder() const;
  [[noreturn]] void refuseFree(System& system, Index node) const;

  std::vector<int> surface_indices_;
  Precision precision_ = Precision::double_precision;
  std::string cache_folder_;
  double memory_limit_ = 0, rotation_bound_ = 0.1, strain_bound_ = 0.1;
  int kept_count_ = 0, interior_count_ = 0;
  bool from_cache_ = false;
  Measured measured_;
  double precomputation_ = 0;
  std::vector<int> dragged_nodes_;
  std::vector<Vec3> drag_forces_;

  Index active_ = 0, first_active_ = 0;
  std::vector<Index> active_rows_;
  double dt_ = 0;
  Array<double> owned_compliance_;
  const void* compliance_ = nullptr;
  std::size_t compliance_bytes_ = 0;
  SectionFile file_;
  std::string file_name_;
  std::unique_ptr<PartialCholesky> factor_;
  std::vector<double> inertia_, damping_;
  std::vector<double> force_, shift_;  ///< constant loads and shifts of the diagonal on free nodes
  Array<double> swept_;                ///< force_ after forward()
  Array<double> constant_force_;
  std::vector<double> interior_constant_;  ///< L_II^-1 f_I of what does not change, shape (3 interior)
  Array<double> sweep_, timed_reduced_;    ///< over all free nodes
  bool behind_ = false, asks_force_ = false, factor_checked_ = false;
  Array<double> origin_;                        ///< x_0 of active nodes, shape (padded)
  std::vector<Touch> moved_, pulls_, touches_;  ///< the last is both
  std::vector<NodeProjector> touching_, touching_now_;
  std::vector<Vec3> touched_before_;
  Eigen::MatrixXd touch_columns_;
  Eigen::LLT<Eigen::MatrixXd> touch_factor_;
  Eigen::VectorXd wanted_, reaction_;
  Eigen::VectorXd weights_;  ///< of rows of E^T C E + S, so that soft springs do not spoil its condition; empty: 1
  std::vector<Hand> hands_;
  bool hands_changed_ = true;
  OtherBodies others_;
  CondensedConditions conditions_;
  CondensedContact contact_;
  std::string touch_fault_, others_fault_;
  double touch_error_ = 0;  ///< of reactions, estimated
  double square_ = 0;       ///< sum of u^2 of the last step [m^2]
  LinearRange range_;
};

}  // namespace stroma
