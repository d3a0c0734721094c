// SPDX-License-Identifier: LGPL-2.1-or-later
// Query sets of continuous collision detection in the form in which they are published (Wang, Ferguson, Schneider, Jiang, Attene and
// Panozzo 2021): a line is a point of rational coordinates, and eight lines are a query,
//   x numerator, x denominator, y numerator, y denominator, z numerator, z denominator, truth
// first the four points where the motion starts, then the same four where it ends. They are a vertex and the corners of a triangle,
// or the ends of one edge and of another. The truth is 1 where both meet on their way.
#pragma once
#include <iosfwd>
#include <string>
#include <vector>

#include "framework/collision/pair_distances.h"

namespace stroma::test {

struct Query {
  FourPoints start, end;
  bool meets = false;
  bool is_rounded = false;  ///< a coordinate is no double
};

/// Throws std::runtime_error with file and line. `truth`: a JSON array of booleans, one for each query, for a file whose lines have
/// six numbers; empty: the lines have the truth, or it is in mma_bool.json beside the file or in mma_bool/STEM_mma_bool.json.
std::vector<Query> readQueries(const std::string& file, const std::string& truth = {});

/// By "vertex-face" or "edge-edge" in the path, or a name that ends in vf or ee. Throws std::runtime_error for others.
PairKind kindOfQueries(const std::string& file);

/// What the engine makes of them.
struct QueryCounts {
  long queries = 0, meeting = 0, rounded = 0;
  long missed = 0;      ///< meet, and the engine lets them go all their way
  long cut = 0;         ///< do not meet, and are cut short
  long at_once = 0;     ///< of these, by all of their way
  double way_left = 0;  ///< of what is cut although it is free: the mean part of the way that is made
  double seconds = 0;   ///< processor time of all ways
  // in rational numbers
  long checked = 0;
  long touching = 0;            ///< have a point in common where the engine stops
  long wrong_certificates = 0;  ///< the engine's exact test of the start, the end or the stop says something else
  double distance_error = 0;    ///< of the distance at the start, over the size of the pair
  bool isGood() const { return missed == 0 && touching == 0 && wrong_certificates == 0; }
  void add(const QueryCounts& other);
};
struct QueryOptions {
  double left = 0.1;  ///< see StepOptions
  long exact = 1000;  ///< queries of a file that are checked in rational numbers
};
QueryCounts answer(PairKind kind, const std::vector<Query>& queries, const QueryOptions& options);

/// The command: options, files and folders. Returns its exit code: 0, 1: something was missed or is wrong, 2: bad input.
int runQueries(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err);

}  // namespace stroma::test
