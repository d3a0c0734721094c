// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of S A S = L L^T in single precision by fronts, S diagonal: see front_plan.h and front_kernels.h. Subtrees of the
// elimination tree are factored by threads, and then the supernodes above them one by one, each in pieces of its columns and
// rows. What is done in which order does not depend on the number of threads.
#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "components/direct_solvers/front_kernels.h"
#include "components/direct_solvers/front_plan.h"
#include "components/direct_solvers/supernodal_numbers.h"
#include "framework/algebra/memory.h"
#include "framework/algebra/stop.h"

namespace stroma {

/// With its work space.
class FrontNumbers {
 public:
  /// A pattern that is to be factored, perhaps often. The arrays stay the caller's.
  void setPattern(const SupernodalPattern& pattern, const int* lower_start, const int* lower_rows);
  /// Entry i of the lower triangle is `values`[source[i]], scaled by those of its row and its column.
  SupernodalEnd factor(const double* values, const std::vector<int>& source, const std::vector<double>& scale, StopToken stop);
  /// x <- (S A S)^-1 x in the order of the factor.
  void solve(float* x);
  void release();  ///< the memory of numbers, until the next factor()

 private:
  struct Work {
    Array<float> updates;
  };
  class Works {
   public:
    std::unique_ptr<Work> take(std::size_t updates);
    void giveBack(std::unique_ptr<Work> work);
    void release() { free_.clear(); }

   private:
    std::mutex access_;
    std::vector<std::unique_ptr<Work>> free_;
  };
  FrontParts frontOf(int s, float* own);
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
  Works works_;
};

}  // namespace stroma
