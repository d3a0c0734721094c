// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/watched_files.h"

#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

#include "framework/scene/load.h"

namespace stroma::command {
namespace {

namespace fs = std::filesystem;

/// Where a file is, or where it would be looked for first.
std::string placeOf(const std::string& name, const std::string& folder) {
  const std::string found = findFile(name, folder, nullptr);
  return found.empty() ? (fs::path(folder) / name).string() : found;
}

/// Files that the attributes of an element may name.
void addNamed(const std::vector<AttributeDescription>& attributes, const std::string& folder,
              std::vector<std::string>& files) {
  for (const AttributeDescription& attribute : attributes) {
    std::string name = attribute.name;
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    if (name.find("file") == std::string::npos || attribute.value.empty()) continue;
    files.push_back(placeOf(attribute.value, folder));
  }
}

/// The scene with all that it includes, each file by itself: one that cannot be read hides no other.
class NamedFiles {
 public:
  void addScene(const std::string& file, int depth) {
    std::error_code error;
    files.push_back(file);
    if (depth > limits_.include_depth || !seen_.insert(fs::weakly_canonical(file, error)).second) return;
    if (!fs::is_regular_file(file, error) || fs::file_size(file, error) > limits_.file_bytes) return;
    std::ifstream stream(file, std::ios::binary);
    const std::string text(std::istreambuf_iterator<char>(stream), {});
    Diagnostics diagnostics;  // what the run says is enough
    addNode(readXml(text, file, limits_, diagnostics), depth);
  }

  std::vector<std::string> files;

 private:
  void addNode(const NodeDescription& node, int depth) {
    addNamed(node.attributes, node.folder, files);
    for (const ComponentDescription& component : node.components) addComponent(component, depth);
    for (const NodeDescription& child : node.children) addNode(child, depth);
  }

  void addComponent(const ComponentDescription& component, int depth) {
    addNamed(component.attributes, component.folder, files);
    if (component.type == "include") {
      if (const AttributeDescription* href = component.find("href"); href && !href->value.empty())
        addScene(placeOf(href->value, component.folder), depth + 1);
    } else if (const std::string prefab = findFile("Objects/" + component.type + ".xml", component.folder, nullptr);
               !prefab.empty()) {
      addScene(prefab, depth + 1);
    }
  }

  const ReadLimits limits_;
  std::set<fs::path> seen_;
};

}  // namespace

std::vector<std::string> filesNamedBy(const std::string& scene) {
  NamedFiles named;
  try {
    named.addScene(scene, 0);
  } catch (const std::exception&) {  // those found so far; what the run says of it is enough
  }
  return named.files;
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
