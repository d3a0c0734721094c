// SPDX-License-Identifier: LGPL-2.1-or-later
// The list of `stroma regress`. '#' starts a comment; the first other line is the folder of the references, relative to
// the list; then one case a line:
//   SCENE STEPS TOLERANCE [PATH.ATTR=VALUE ...] [data=PATH.NAME[:TOLERANCE] ...] [unconverged] [bits=processor]
// with the scene relative to the list.
#pragma once
#include <string>
#include <vector>

#include "tools/command/regression_data.h"

namespace stroma::command {

struct RegressionCase {
  std::string scene;  ///< path that can be opened
  long steps = 0;
  double tolerance = 0;
  std::vector<std::string> overrides;  ///< PATH.ATTR=VALUE
  std::vector<WatchedData> data;       ///< compared besides the states
  bool accepts_unconverged = false;    ///< solves that end before their tolerance are part of the case
  bool bits_of_processor = false;      ///< the scene calls BLAS outside of steps: its bits are not stored
  std::string name;  ///< scene and overrides as one word: folder of the references, unique in the list
};

struct RegressionList {
  std::string reference_folder;
  std::vector<RegressionCase> cases;
};

/// Throws UsageError with file, line and what was expected.
RegressionList readRegressionList(const std::string& file);

}  // namespace stroma::command
