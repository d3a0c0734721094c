// SPDX-License-Identifier: LGPL-2.1-or-later
// Results in JUnit's XML, which build servers read: one <testsuite> with a <testcase> for each case.
#pragma once
#include <string>
#include <vector>

namespace stroma::command {

struct JunitCase {
  std::string name;
  double seconds = 0;   ///< wall time
  std::string failure;  ///< a sentence; empty when the case passed
};

/// Writes `file`. Control characters, which XML forbids, become '?'. Throws std::runtime_error when it cannot.
void writeJunit(const std::string& suite, const std::vector<JunitCase>& cases, const std::string& file);

}  // namespace stroma::command
