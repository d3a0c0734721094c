// SPDX-License-Identifier: LGPL-2.1-or-later
// The numbers of A = L L^T for an analysed pattern, supernode by supernode from the left (Ng and Peyton 1993): the loop
// of CHOLMOD's cholmod_super_numeric with the same calls of BLAS in the same order, hence the same bits. That one says
// nothing and cannot be stopped until it is over, minutes later for a large body; this one looks between its calls.
#pragma once
#include <vector>

#include "framework/algebra/memory.h"
#include "framework/algebra/stop.h"

namespace stroma {

/// A lower triangle by columns.
struct LowerTriangle {
  const int *start, *rows;  ///< shape (columns + 1), (entries)
  const double* values;
};

/// Where the columns and rows of a factor's supernodes lie; see cholmod_factor.
struct SupernodalPattern {
  int columns = 0, count = 0;
  int largest_update = 0;       ///< numbers of the largest update of one supernode by another
  const int* first = nullptr;   ///< column, shape (count + 1)
  const int* start = nullptr;   ///< of the rows in `rows`, shape (count + 1); the first rows are the columns' own
  const int* offset = nullptr;  ///< of the values, column by column, shape (count + 1)
  const int* rows = nullptr;
};

struct SupernodalEnd {
  bool stopped = false;
  int bad_column = -1;  ///< whose pivot is not positive
};

/// With its work space.
class SupernodalNumbers {
 public:
  /// Fills `values` of the factor, or stops on the way: they are of no use then.
  SupernodalEnd factor(const LowerTriangle& matrix, const SupernodalPattern& pattern, double* values, StopToken stop);

 private:
  void begin(const LowerTriangle& matrix, int s);
  bool updateBy(int d, int s);
  bool factorDiagonal(int s, int& info);
  bool solveBelow(int s);
  void waitFor(int d, int done);

  SupernodalPattern pattern_;
  double* values_ = nullptr;
  StopToken stop_;
  std::vector<int> place_;      ///< of a row in the supernode under way, shape (columns)
  std::vector<int> supernode_;  ///< of a column, shape (columns)
  /// Supernodes that still have to act wait in the list of the next one that they act on; how many rows of each are done.
  std::vector<int> list_, next_, done_;
  std::vector<int> relative_;
  Array<double> update_;
};

}  // namespace stroma
