// SPDX-License-Identifier: LGPL-2.1-or-later
// The cases that have been made, in a file that grows by a line with each: the same command goes on after it.
#pragma once
#include <map>
#include <string>

#include "framework/scene/output_file.h"
#include "tools/stress/outcome.h"

namespace stroma::stress {

class Record {
 public:
  /// Reads what is there of cases with this key, which says all that they depend on; other cases are dropped. Throws
  /// OutputError.
  Record(const std::string& file, const std::string& key);
  const std::map<long, Outcome>& made() const { return made_; }
  void add(long number, const Outcome& outcome);

 private:
  OutputFile file_;
  std::map<long, Outcome> made_;
};

}  // namespace stroma::stress
