// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

namespace stroma::bench {

struct AccuracyRequest {
  std::string problem;      ///< one of them, as "column", or some of its sizes too, as "column/20,40"; empty: all
  std::string csv_file;     ///< the tables are written to it; empty: they are not
  std::string stored_file;  ///< what has changed since it was written is said; empty: it is not
  std::string beads;        ///< the truth cube's measured beads; empty: that problem is left out, with a word
  int repetitions = 3;      ///< solutions of each, of which the quickest counts
};

/// The standing set: problems with independent references, by all ways that apply, each with its error and its time, and what
/// they say in sentences. Prints tables. Throws std::invalid_argument for a problem or a size that is none.
void compareAccuracy(const AccuracyRequest& request);

/// Those of a problem that are asked for: none stands for all.
bool isAsked(const std::vector<int>& sizes, int size);

/// Processor time of this thread so far.
double threadMilliseconds();

}  // namespace stroma::bench
