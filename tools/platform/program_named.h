// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>

namespace stroma {

/// The absolute path of the program that a shell would start by this name, or empty. In PATH an empty folder is the one where this
/// process works.
inline std::string programNamed(const std::string& name) {
  namespace fs = std::filesystem;
  const char* const path = std::getenv("PATH");
  std::istringstream folders(path ? path : "/usr/bin:/bin");
  for (std::string folder; std::getline(folders, folder, ':');) {
    std::error_code error;
    const std::string file = fs::absolute((folder.empty() ? "." : folder) + "/" + name, error).string();  // fails without a folder here
    if (!error && access(file.c_str(), X_OK) == 0 && fs::is_regular_file(file, error)) return file;
  }
  return {};
}

}  // namespace stroma
