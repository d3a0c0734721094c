// SPDX-License-Identifier: LGPL-2.1-or-later
// SparseLDLSolver: a direct solver, A x = b by a factorisation of the assembled matrix.
//
// A symmetric positive definite matrix is factored as P A P^T = L L^T by CHOLMOD's supernodal method (Chen, Davis,
// Hager, Rajamanickam 2008) on 3x3 blocks. The pattern is ordered and analysed once (minimum degree by AMD, and nested
// dissection by METIS where ten factorisations may repay it; the one with fewer flops is kept); the numbers are factored
// again only when the matrix may have changed, so a scene of constant stiffness, mass and time step is factored once. The
// residual of each solve is measured, and the solve refined where it is above 1e-10 |b|. What refinement leaves above
// 1e-5 |b| is told.
//
// Factors of more than 5e7 operations (some 1,000 nodes of a cube), and of 180 for each of their numbers, are made in single
// precision: half of the bytes, and twice as many numbers in a register. Their solutions are refined by conjugate gradients in
// double precision, two iterations of which are usual, until the error is 1e-11 of the solution in the norm of the energy and the
// residual 1e-11 |b|. Where the matrix is too ill-conditioned for that, or its factors serve so many right sides that the
// iterations cost more, it is factored in double precision. `precision` chooses by hand.
//
// Many right sides of one matrix, as those of the conditions of contact, go through the factors in blocks of 16 or 32: a number that is
// read serves all of them, and parts of the factor that no right side reaches are passed by on the way forward (side_solves.h).
//
// SOFA's solver of this name computes L D L^T without pivoting and gives some x for an indefinite matrix too. Here a
// matrix that is not positive definite is reported with the node at which it shows, and the integrator decides what to
// do. When some force field has an unsymmetric stiffness, as tangent="exact" of hexahedra, its symmetric part is factored
// and GMRES (Saad, Schultz 1986) does the rest in some ten products: the part that is not symmetric is small where
// strains are. Where the symmetric part is not positive definite, or GMRES gets no further, the matrix is factored as
// L U (Eigen, COLAMD ordering), which takes many times as long.
//
// Example:
// <Node name="root" dt="0.01" gravity="0 -9.81 0">
//   <EulerImplicitSolver/>
//   <SparseLDLSolver/>
//   <MechanicalObject position="0 0 0  1 0 0  0 1 0  0 0 1"/>
//   <UniformMass totalMass="1"/>
//   <FixedProjectiveConstraint indices="0 1 2"/>
// </Node>
#include "components/direct_solvers/cholesky_factor.h"
#include "components/direct_solvers/symmetric_part_factor.h"
#include "framework/scene/archive.h"
#include "framework/scene/factory.h"

namespace stroma {
namespace {

class SparseLDLSolver final : public DirectSolver {
 public:
  void declare(DataTable& table) override;
  void init() override { tell(); }
  void reset() override {
    memories_.forEach([](Kept& kept) { kept = {}; });
  }
  bool needsSymmetric() const override { return false; }
  SolveReport solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x, const SolveTerms& terms) override;
  void serializeFor(SystemMatrix& matrix, Archive& archive) override;
  void keepFor(SystemMatrix& matrix) override { memories_.of(matrix).before_step = memories_.of(matrix).now; }
  void takeBackFor(SystemMatrix& matrix) override { memories_.of(matrix).now = memories_.of(matrix).before_step; }

 protected:
  std::unique_ptr<Factorisation> makeFactorisation(bool symmetric) const override {
    if (symmetric) return CholeskyFactor::make(precision_, record_);
    return std::make_unique<SymmetricPartFactor>();
  }
  void noteFactored(const Factorisation& factors) override;
  SolveStop uselessFactor() const override { return SolveStop::not_definite; }

 private:
  /// For each matrix.
  struct Kept {
    FactorMemory now, before_step;
  };
  void tell();

  bool precompute_ = true, parallel_inverse_ = false;
  FactorPrecision precision_ = FactorPrecision::automatic;
  std::string ordering_, told_;
  double flops_ = 0, entries_ = 0, applications_ = 0;
  int changes_ = 0;
  std::shared_ptr<FactorRecord> record_ = std::make_shared<FactorRecord>();
  bool is_factored_ = false, told_single_ = false;
  PerMatrix<Kept> memories_;
};

void SparseLDLSolver::declare(DataTable& table) {
  DirectSolver::declare(table);
  table.addChoice("precision", precision_, {"auto", "double", "single"})
      .help("of the factors; what is solved with those in single precision is refined in double");
  table.add("precomputeSymbolicDecomposition", precompute_)
      .help("SOFA's; without effect: the analysis is always made once for each pattern");
  table.add("parallelInverseProduct", parallel_inverse_).help("SOFA's; without effect");
  table.add("ordering", ordering_).help("METIS or AMD, or COLAMD of an L U factorisation; of the last one").output();
  table.add("factorFlops", flops_).help("operations of the last factorisation; 0 of L U").unit("-").output();
  table.add("factorEntries", entries_).help("numbers in the factors made last").unit("-").output();
  table.add("factorPrecision", told_).help("in what precision factors are made").output();
  table.add("applications", applications_).help("of factors in single precision in a solve, on average").unit("-").output();
  table.add("precisionChanges", changes_)
      .help("how often factors in single precision were given up for those in double")
      .unit("-")
      .output();
}

SolveReport SparseLDLSolver::solveAll(SystemMatrix& matrix, std::span<const ConstRows> b, std::span<const Rows> x,
                                      const SolveTerms& terms) {
  struct Call {
    FactorRecord& record;
    Call(FactorRecord& of, FactorMemory& memory) : record(of) { record.memory = &memory; }
    ~Call() { record.memory = nullptr; }
  };
  SolveReport report;
  {
    const Call call(*record_, memories_.of(matrix).now);
    report = DirectSolver::solveAll(matrix, b, x, terms);
  }
  tell();
  return report;
}

void SparseLDLSolver::serializeFor(SystemMatrix& matrix, Archive& archive) {
  if (precision_ == FactorPrecision::in_double) return;
  FactorMemory& now = memories_.of(matrix).now;
  archive.value("precision_values", now.values);
  archive.value("precision_double", now.is_double);
  archive.value("precision_waiting", now.waiting);
  archive.value("precision_penalty", now.penalty);
  archive.value("precision_lost", now.lost);
  archive.value("precision_saved", now.saved);
}

/// Formats only when something has changed.
void SparseLDLSolver::tell() {
  if (record_->solves > 0) applications_ = double(record_->applications) / double(record_->solves);
  const bool is_single = record_->is_single;
  if (!told_.empty() && told_single_ == is_single && changes_ == record_->given_up && is_factored_ == (flops_ > 0)) return;
  told_single_ = is_single, changes_ = record_->given_up, is_factored_ = flops_ > 0;
  if (is_factored_)
    told_ = is_single ? "single, refined in double" : "double";
  else
    told_ = precision_ == FactorPrecision::automatic ? "single where one takes more than 5e7 operations, refined in double"
            : precision_ == FactorPrecision::in_single ? "single, refined in double"
                                                       : "double";
}

void SparseLDLSolver::noteFactored(const Factorisation& factors) {
  if (const auto* cholesky = dynamic_cast<const CholeskyFactor*>(&factors)) {
    ordering_ = cholesky->ordering();
    flops_ = cholesky->flops(), entries_ = cholesky->entries();
  } else {
    const auto& unsymmetric = static_cast<const SymmetricPartFactor&>(factors);
    ordering_ = unsymmetric.ordering();
    flops_ = unsymmetric.flops(), entries_ = unsymmetric.entries();
    record_->is_single = false;
  }
}

}  // namespace
}  // namespace stroma

STROMA_COMPONENT(sparse_ldl_solver) {
  factory.add<stroma::SparseLDLSolver>("SparseLDLSolver",
                                       "direct solver: sparse Cholesky, factored only when values changed");
}
