// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <memory>

#include "components/iterative_solvers/multigrid_products.h"
#include "components/iterative_solvers/preconditioner.h"

namespace stroma {

/// A V-cycle of smoothed aggregation over the assembled matrix, kept while the matrix changes. Each solve is compared
/// with the first one after the hierarchy was made, by iterations for a decade of the residual: what it took more is
/// lost, and once more is lost than a new hierarchy costs, the next matrix gets one. Pairs that come and go in the pattern
/// count as other values do: what solves is the matrix as it is. Costs are counted in iterations, so that each run does the
/// same. Of a matrix that is not symmetric the symmetric part gets the hierarchy.
///
/// A hierarchy of former values is turned with the body, B = R B_0 R^T: R_i is how much the surroundings of node i have turned
/// since, as in WarpedFactor. Where products cost little the finest level goes by them, and is of the matrix as it is.
class Multigrid final : public ApproximateInverse {
 public:
  bool follow(SystemMatrix& matrix, SolveReport& report, StopToken stop) override;
  void apply(ConstRows r, Rows z) override { now_.hierarchy->apply(r, z, now_.turns.get(), by_products_ ? &products_ : nullptr); }
  void solved(const SolveReport& report) override { solved(report, 1); }
  /// Of a solve that began with this share of |b|.
  void solved(const SolveReport& report, double began);
  bool giveUp() override { return now_.fresh ? false : (now_ = {}, true); }
  void reset() override { now_ = kept_ = {}; }
  /// The hierarchies themselves are shared, and never changed once made.
  void keep(const SystemMatrix& matrix) override { kept_ = now_, kept_current_ = isCurrent(matrix); }
  void takeBack(const SystemMatrix& matrix) override;
  void serialize(SystemMatrix& matrix, Archive& archive) override { serialize(matrix, archive, false); }
  /// `never_changes`: nothing in the matrix depends on the state. A hierarchy of it is made again where it is read.
  void serialize(SystemMatrix& matrix, Archive& archive, bool never_changes);

  /// What an assembly and a hierarchy cost, in iterations with it: some 20, and some 50 where the matrix has another pattern by now.
  /// Of the matrix followed last.
  double iterationsWorth() const { return iterations_worth_; }

  const amg::Hierarchy* hierarchy() const { return now_.hierarchy.get(); }
  /// Whether it is of the matrix followed last.
  bool isFresh() const { return now_.fresh; }
  /// Whether it is turned with the body.
  bool isTurned() const { return now_.turns != nullptr; }
  /// How often one was made.
  int made() const { return made_; }

 private:
  /// What later solves depend on.
  struct Memory {
    std::shared_ptr<amg::Hierarchy> hierarchy;  ///< null: none so far
    MatrixKey key;                              ///< of the last follow()
    bool fresh = false;                         ///< the last follow() made the hierarchy
    bool renew = false;                         ///< the next one that sees other values does
    double rate = 0;                            ///< iterations for a decade with the fresh one; 0: not known yet
    double lost = 0;                            ///< iterations more than with a fresh one, since it was made
    bool other_pattern = false;                 ///< than when the hierarchy was made, at some time since
    double stiffest = 0;                        ///< see amg::ProductLevel::follow()
    std::shared_ptr<Vector> turns;              ///< of nodes since it was made, see amg::Hierarchy::apply(); null: none
  };
  bool fits(const SystemMatrix& matrix) const {
    return now_.hierarchy && now_.hierarchy->fine.a.rows() == matrix.rows() &&
           (now_.hierarchy->hasFineBlocks() || amg::ProductLevel::isWorth(matrix, *now_.hierarchy));
  }
  bool isCurrent(const SystemMatrix& matrix) const { return now_.key == matrix.key() || taken_back_ == matrix.key(); }
  bool make(SystemMatrix& matrix, SolveReport& report, StopToken stop);
  bool followByProducts(const SystemMatrix& matrix, SolveReport& report);
  void price(const SystemMatrix& matrix);
  void turn(const SystemMatrix& matrix);
  void readHierarchy(SystemMatrix& matrix, Archive& archive, bool is_remade, bool is_current);

  Memory now_, kept_;
  bool kept_current_ = false;
  MatrixKey taken_back_;  ///< what a step that was taken back left of the matrix of now_
  std::shared_ptr<Vector> spare_turns_;  ///< for the next ones: a step allocates none
  int made_ = 0;
  double iterations_worth_ = 0;
  amg::ProductLevel products_;  ///< of the matrix followed last
  bool by_products_ = false;    ///< it is the finest level
};

}  // namespace stroma
