// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/files.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "framework/scene/load.h"

namespace stroma {

namespace fs = std::filesystem;

std::vector<std::string> environmentDataPaths() {
  std::vector<std::string> folders;
  for (const char* variable : {"STROMA_DATA_PATH", "SOFA_DATA_PATH"}) {
    const char* list = std::getenv(variable);
    std::istringstream parts(list ? list : "");
    for (std::string part; std::getline(parts, part, ':');)
      if (!part.empty()) folders.push_back(part);
  }
  return folders;
}

std::string findFileIn(const std::string& given, const std::string& folder, const std::vector<std::string>& data_paths,
                       std::vector<std::string>* searched) {
  std::error_code none;
  const auto aFolder = [&](const fs::path& path) { return fs::is_directory(path, none) ? ", where it is a folder" : ""; };
  const auto isFile = [&](const fs::path& path) { return fs::exists(path, none) && !fs::is_directory(path, none); };
  if (given.empty()) return {};
  if (fs::path(given).is_absolute()) {
    if (searched) searched->push_back(fs::path(given).parent_path().string() + aFolder(given));
    return isFile(given) ? given : std::string();
  }
  std::vector<std::string> folders{folder.empty() ? "." : folder};
  folders.insert(folders.end(), data_paths.begin(), data_paths.end());
  for (const std::string& candidate : folders) {
    const fs::path path = fs::path(candidate) / given;
    const std::string place = candidate + aFolder(path);
    if (searched && std::find(searched->begin(), searched->end(), place) == searched->end()) searched->push_back(place);
    if (isFile(path)) return fs::absolute(path).lexically_normal().string();
  }
  return {};
}

std::string findFile(const std::string& given, const std::string& folder, std::vector<std::string>* searched) {
  return findFileIn(given, folder, environmentDataPaths(), searched);
}

std::string searchedText(const std::vector<std::string>& searched) {
  std::string out = searched.size() == 1 ? "folder searched: " : "folders searched: ";
  for (std::size_t i = 0; i < searched.size(); ++i) out += (i ? ", " : "") + searched[i];
  return out;
}

}  // namespace stroma
