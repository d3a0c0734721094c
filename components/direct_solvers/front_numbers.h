// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of S A S = L L^T in single precision by fronts, S diagonal: see front_plan.h and front_kernels.h. Subtrees of the
// elimination tree are factored by threads, and then the supernodes above them one by one, each in pieces of its columns and
// rows. What is done in which order does not depend on the number of threads.
#pragma once
#include <vector>

#include "components/direct_solvers/front_kernels.h"
#include "components/direct_solvers/front_plan.h"
#include "components/direct_solvers/side_solves.h"
#include "components/direct_solvers/supernodal_numbers.h"
#include "framework/algebra/memory.h"
#include "framework/algebra/stop.h"

namespace stroma {

/// Numbers too small for their type become zero on this thread: they would be computed with at a hundredth of the speed.
class FlushTiny {
 public:
  FlushTiny();
  ~FlushTiny();
  FlushTiny(const FlushTiny&) = delete;

 private:
  unsigned before_;
};

/// With its work space.
class FrontNumbers {
 public:
  /// A pattern that is to be factored, perhaps often. The arrays stay the caller's.
  void setPattern(const SupernodalPattern& pattern, const int* lower_start, const int* lower_rows);
  /// Entry i of the lower triangle is `values`[source[i]], scaled by those of its row and its column.
  SupernodalEnd factor(const double* values, const std::vector<int>& source, const std::vector<double>& scale, StopToken stop);
  /// x <- (S A S)^-1 x in the order of the factor.
  void solve(float* x);
  /// The same for a block of right sides, see solveSides().
  template <class NumberOf>
  void solveSides(int count, const NumberOf& numberOf, SideWork<float>& work) {
    const FlushTiny flush;
    stroma::solveSides(pattern_, plan_.parent, [this](int s) { return panelOf(s); }, count, numberOf, work);
  }
  void release();  ///< the memory of numbers, until the next factor()

 private:
  struct Work {
    Array<float> updates;
  };
  FrontParts frontOf(int s, float* own);
  SidePanel<float> panelOf(int s);
  SupernodalEnd factorPart(const std::vector<int>& supernodes);
  SupernodalEnd factorInPieces(int s);
  void load(int s, const FrontParts& front);
  void add(int s, const FrontParts& front, float* own, int first, int last);
  void addInPieces(int s, const FrontParts& front, int first, int last);
  int factorPanel(const FrontParts& front);
  int factorBlock(const FrontParts& front, int j, bool in_pieces);
  void subtractBlock(const FrontParts& front, int j);
  void forward(int s, const float* x, bool in_pieces);
  void backward(int s, float* x, bool in_pieces);
  /// y -= A x and y -= A^T x by pieces of rows and columns.
  void subtractProduct(const float* a, int lda, int rows, int columns, const float* x, float* y, bool in_pieces);
  void subtractTransposed(const float* a, int lda, int rows, int columns, const float* x, float* y, bool in_pieces);

  SupernodalPattern pattern_;
  const int *lower_start_ = nullptr, *lower_rows_ = nullptr;
  FrontPlan plan_;
  const FrontKernels* kernels_ = nullptr;
  Array<float> values_, shared_, vectors_;
  std::vector<SupernodalEnd> ends_;  ///< of the parts
  const double* from_ = nullptr;
  const int* source_ = nullptr;
  const double* scale_ = nullptr;
  StopToken stop_;
  WorkPool<Work> works_;
};

}  // namespace stroma
