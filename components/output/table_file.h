// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "framework/scene/archive.h"
#include "framework/scene/output_file.h"

namespace stroma {

/// A text file of lines, each in the file when it has been written. A run that goes on from a checkpoint continues it
/// where the checkpoint was written: later lines of an earlier run are cut off. Throws OutputError.
class TableFile {
 public:
  /// True when the file is new: `head` is in it, and nothing else. `goes_on`: the run started from a checkpoint; throws
  /// std::runtime_error when the file has lost lines since.
  bool open(const std::string& path, bool goes_on, const std::string& head);
  void write(const std::string& lines);
  void close();
  /// Where the file ends now; see Component::serialize().
  void serialize(Archive& archive, const std::string& name);

 private:
  OutputFile file_;
  long long end_ = -1;  ///< bytes when it was closed or stored; -1: never opened
};

}  // namespace stroma
