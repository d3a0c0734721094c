// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of A = L L^T for an analysed pattern, supernode by supernode from the left (Ng and Peyton 1993). CHOLMOD's
// cholmod_super_numeric says nothing and cannot be stopped until it is over, minutes later for a large body, and runs on
// one thread wherever bits must not depend on threads. This looks between its calls of BLAS whether it shall stop. Small
// factors are made in CHOLMOD's order, small panels without the BLAS (small_panels.h). Large ones are made by threads: subtrees
// of the elimination tree first, and then the supernodes above them one by one, each in pieces of its columns and rows. What
// is done in which order does not depend on the number of threads.
#pragma once
#include <memory>
#include <mutex>
#include <vector>

#include "components/direct_solvers/supernodal_plan.h"
#include "framework/algebra/memory.h"
#include "framework/algebra/stop.h"

namespace stroma {

/// A lower triangle by columns.
struct LowerTriangle {
  const int *start, *rows;  ///< shape (columns + 1), (entries)
  const double* values;
};

struct SupernodalEnd {
  bool stopped = false;
  int bad_column = -1;  ///< whose pivot is not positive
};

/// With its work space.
class SupernodalNumbers {
 public:
  /// A pattern that is to be factored, perhaps often.
  void setPattern(const SupernodalPattern& pattern) {
    pattern_ = pattern;
    plan_ = planOf(pattern);
  }
  /// Fills `values` of the factor, or stops on the way: they are of no use then.
  SupernodalEnd factor(const LowerTriangle& matrix, double* values, StopToken stop);

 private:
  /// What one thread needs.
  struct Work {
    std::vector<int> place;     ///< of a row in the supernode under way, shape (columns)
    std::vector<int> relative;  ///< the same for the rows of an update
    Array<double> update;
  };
  /// Work space of pieces that run at once.
  class Works {
   public:
    std::unique_ptr<Work> take(int columns);
    void giveBack(std::unique_ptr<Work> work);

   private:
    std::mutex access_;
    std::vector<std::unique_ptr<Work>> free_;
  };

  SupernodalEnd factorList(const LowerTriangle& matrix, const std::vector<int>& supernodes, Work& work);
  SupernodalEnd factorParts(const LowerTriangle& matrix);
  SupernodalEnd factorInPieces(const LowerTriangle& matrix, int s, Work& work);
  void begin(const LowerTriangle& matrix, int s, Work& work);
  bool updateColumns(const SupernodalPlan::Update& u, int s, int first, int last, const std::vector<int>& place,
                     Work& work);
  bool factorDiagonal(int s, int& info);
  bool solveBelow(int s);
  int factorPanel(int s);

  SupernodalPattern pattern_;
  SupernodalPlan plan_;
  double* values_ = nullptr;
  StopToken stop_;
  Works works_;
};

}  // namespace stroma
