// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <cstdio>
#include <memory>
#include <string>

#include "framework/scene/archive.h"

namespace stroma {

/// A text file of lines. A run that goes on from a checkpoint continues it where the checkpoint was written: later
/// lines of an earlier run are cut off. Throws ComponentError with a sentence that starts with `owner`.
class TableFile {
 public:
  /// True when the file is new: `head` is in it, and nothing else. `goes_on`: the run started from a checkpoint.
  bool open(const std::string& owner, const std::string& path, bool goes_on, const std::string& head);
  void write(const std::string& line);
  void close();
  /// Where the file ends now; see Component::serialize().
  void serialize(Archive& archive, const std::string& name);

 private:
  struct Close {
    void operator()(std::FILE* file) const { std::fclose(file); }
  };
  std::string owner_;
  std::unique_ptr<std::FILE, Close> file_;
  long long end_ = -1;  ///< bytes when it was closed or stored; -1: never opened
};

}  // namespace stroma
