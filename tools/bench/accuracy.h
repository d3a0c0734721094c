// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

namespace stroma::bench {

/// The standing set: problems with independent references, by all ways that apply, each with its error and its time, and what
/// they say in sentences. `problem`: one of them; empty: all. Prints tables; writes them to `csv_file` unless it is empty, and
/// says what has changed since `stored_file` was written, unless that is empty. Throws std::invalid_argument for a name that is
/// none. `beads`: the file of the truth cube's measured beads; empty: that problem is left out, with a word.
void compareAccuracy(const std::string& problem, const std::string& csv_file, const std::string& stored_file,
                     const std::string& beads);

/// Processor time of this thread so far.
double threadMilliseconds();

}  // namespace stroma::bench
