// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/watched_files.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>

#include "framework/scene/load.h"

namespace stroma::command {
namespace {

namespace fs = std::filesystem;

/// Files that the attributes of an element may name: where they are, or where they would be looked for first.
void addNamed(const std::vector<AttributeDescription>& attributes, const std::string& folder,
              std::vector<std::string>& files) {
  for (const AttributeDescription& attribute : attributes) {
    std::string name = attribute.name;
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (name.find("file") == std::string::npos || attribute.value.empty()) continue;
    const std::string found = findFile(attribute.value, folder, nullptr);
    files.push_back(found.empty() ? (fs::path(folder) / attribute.value).string() : found);
  }
}

void addNamed(const NodeDescription& node, std::vector<std::string>& files) {
  addNamed(node.attributes, node.folder, files);
  for (const ComponentDescription& component : node.components) addNamed(component.attributes, component.folder, files);
  for (const NodeDescription& child : node.children) addNamed(child, files);
}

}  // namespace

std::vector<std::string> filesNamedBy(const std::string& scene) {
  std::vector<std::string> files{scene};
  try {
    Diagnostics diagnostics;
    const SceneDescription description = readScene(scene, {}, {}, diagnostics);
    files.insert(files.end(), description.files.begin(), description.files.end());
    addNamed(description.root, files);
  } catch (const std::exception&) {  // what the run says of it is enough
  }
  return files;
}

FileStamps::FileStamps(const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    std::error_code error;
    const std::string path = fs::absolute(file, error).lexically_normal().string();
    stamps_[path] = stampOf(path);
  }
}

std::optional<FileStamps::Stamp> FileStamps::stampOf(const std::string& file) {
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0) return std::nullopt;
  return Stamp{status.st_mtim.tv_sec, status.st_mtim.tv_nsec, status.st_size, status.st_dev, status.st_ino};
}

void FileStamps::takeFrom(const FileStamps& other) {
  for (auto& [file, stamp] : stamps_)
    if (const auto known = other.stamps_.find(file); known != other.stamps_.end()) stamp = known->second;
}

std::string FileStamps::changed() const {
  constexpr std::size_t most = 3;
  std::vector<std::string> told;
  for (const auto& [file, stamp] : stamps_) {
    const std::optional<Stamp> now = stampOf(file);
    if (now == stamp) continue;
    told.push_back(fmt::format("{} {}", fs::path(file).filename().string(),
                               !now    ? "is gone"
                               : stamp ? "was saved"
                                       : "has come"));
  }
  if (told.size() > most) told[most] = fmt::format("and {} more", told.size() - most);
  told.resize(std::min(told.size(), most + 1));
  return fmt::format("{}", fmt::join(told, ", "));
}

std::vector<std::string> FileStamps::files() const {
  std::vector<std::string> files;
  for (const auto& [file, stamp] : stamps_) files.push_back(file);
  return files;
}

}  // namespace stroma::command
