// SPDX-License-Identifier: LGPL-2.1-or-later
// Factors in single precision, and solutions as exact as those of factors in double. A = L L^T (1 + E), E of the size of single
// round-off times the condition of A scaled to a unit diagonal: conjugate gradients with L L^T as the preconditioner and products
// in double precision lose it in two or three iterations where the condition is below 1e6, and in some more where a few slow
// motions of a slender body go beyond. In plain refinement these would not converge (Langou et al. 2006; Carson and Higham
// 2017 use GMRES).
//
// Half of the bytes, and twice as many numbers in a register. Where the iterations of a solve would cost more than factors in
// double precision those are made, mostly after the first few; and so where a pivot is not positive in single precision or a
// direction has no positive energy. The next matrices are then factored in double precision too, twice as many each time;
// likewise where single precision did not pay. There is no memory for numbers in the other precision meanwhile. Where many
// systems are solved with one matrix, factors in double precision are made as soon as the iterations have cost as much. Counts
// decide, not a clock. Whoever uses the factors of another component's matrix gets single precision by applyRoughly() alone.
#pragma once
#include "components/direct_solvers/front_numbers.h"
#include "components/direct_solvers/supernodal_factor.h"

namespace stroma {

class RefinedFactor final : public CholeskyFactor {
 public:
  RefinedFactor(FactorPrecision precision, std::shared_ptr<FactorRecord> record);
  bool analyse(const BlockMatrix& matrix, StopToken stop) override;
  void load(const BlockMatrix& matrix) override;
  SolveStop factor(Index& row, StopToken stop) override;
  void apply(ConstRows b, Rows x) override { applyAll({&b, 1}, {&x, 1}); }
  /// x is zero where the stop that factor() was given ends it, or there are no factors in double precision either.
  void applyAll(std::span<const ConstRows> b, std::span<const Rows> x) override;
  void applyRoughly(ConstRows b, Rows x) override;
  const std::string& ordering() const override { return analysis_->ordering; }
  double flops() const override { return analysis_->flops; }
  double entries() const override { return analysis_->entries; }
  Cost cost() const override;

 private:
  /// The iterations of one right side.
  struct Side {
    Vector residual, step, direction, product;
    double size = 0, first = 0, former = 0, length = 0;  ///< |b|; r^T A^-1 r, the square of an error's energy
    int iterations = 0;
    bool is_solved = false;
  };
  struct Block {
    std::vector<Side> sides;    ///< the first `count` of them
    std::size_t count = 0;
    std::vector<int> going;     ///< sides that are not solved
    std::vector<double> sizes;  ///< of their residuals, scaled
    SideWork<float> work;
  };
  void loadInDouble(const BlockMatrix& matrix);
  SolveStop factorInDouble(Index& row, StopToken stop);
  SolveStop factorInSingle(StopToken stop);
  bool scaleToUnitDiagonal();
  FactorMemory& memory() { return record_->memory ? *record_->memory : own_; }
  void remember();
  void giveUp();
  void waitLonger();
  void applyOnce(ConstRows b, Rows x);
  bool solve(std::span<const ConstRows> b, std::span<const Rows> x, StopToken stop);
  void solveBlock(std::span<const ConstRows> b, std::span<const Rows> x, int most, StopToken stop, Block& block);
  void applyTo(Block& block);
  bool advance(Side& side, Rows x, int k, int most);
  void expectSides(std::size_t count);
  double secondsOfSide(bool in_single) const;
  int mostApplications() const;
  double secondsSaved() const;
  double secondsOfIteration() const;
  void noteSolved(double seconds);

  FactorPrecision wanted_;
  std::shared_ptr<FactorRecord> record_;
  std::shared_ptr<SupernodalAnalysis> analysis_;
  bool uses_single_ = false;  ///< for this pattern
  FactorMemory own_;
  FrontNumbers fronts_;
  bool has_fronts_ = false;      ///< they are those of the loaded values
  BlockMatrix matrix_;           ///< A, when in single precision
  std::int64_t loaded_ = 0;      ///< its values, mixed to one number
  std::vector<double> scale_;    ///< of the unknowns in the order of the factor; powers of two
  std::vector<std::size_t> place_;  ///< of these unknowns among the doubles of rows
  Array<float> solution_;
  WorkPool<Block> blocks_;
  std::vector<int> iterations_;  ///< of each right side, below 0 where they have not solved it
  SupernodalFactor in_double_;
  bool has_analysis_ = false, has_double_ = false;  ///< those of in_double_
  StopToken stop_;               ///< of the last factor(), until the first apply() after it
};

}  // namespace stroma
