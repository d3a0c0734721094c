// SPDX-License-Identifier: LGPL-2.1-or-later
// A file to one complete description: includes are spliced in, overrides applied. Text only, no component exists.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>

#include "framework/scene/dialect.h"
#include "framework/scene/files.h"
#include "framework/scene/load.h"
#include "framework/scene/overrides.h"
#include "framework/scene/prefab.h"
#include "framework/scene/text.h"

namespace stroma {

namespace fs = std::filesystem;

namespace {

class Resolver {
 public:
  Resolver(const ReadLimits& limits, const KnownType& is_known, const std::vector<Override>& overrides, SceneDescription& scene,
           Diagnostics& diagnostics)
      : limits_(limits), is_known_(is_known), overrides_(overrides), scene_(scene), diagnostics_(diagnostics),
        bytes_left_(limits.file_bytes) {}

  /// Reads `file` and everything that it includes. False when it cannot be used; the reason has been reported at `where`.
  bool read(const std::string& file, const SourceLocation& where, int depth, NodeDescription& root, bool is_prefab = false) {
    std::error_code none;
    const std::string canonical = fs::canonical(file, none).string();
    if (std::find(chain_.begin(), chain_.end(), canonical) != chain_.end()) return reportCircle(canonical, where);
    if (int(chain_.size()) >= limits_.include_depth)
      return diagnostics_.error(where, {}, "files include each other more than " + std::to_string(limits_.include_depth) + " deep"), false;
    std::string text;
    return readText(file, where, text) && take({file, std::move(text), true, is_prefab}, depth, root);
  }
  /// The same for a text that is there already.
  bool take(SceneFileText text, int depth, NodeDescription& root) {
    std::error_code none;
    const std::string file = text.file;
    decodeForeign(text.text, file, is_foreign_ || isForeign(file, {}, overrides_), diagnostics_);
    root = readXml(text.text, file, limits_, diagnostics_);
    if (root.where.file.empty()) return false;
    if (chain_.empty() && isForeign(file, root, overrides_)) {
      is_foreign_ = true;
      for (std::string& folder : foreignDataPaths(file)) scene_.data_paths.push_back(std::move(folder));
      if (!root.find(dialect_attribute)) root.attributes.push_back({dialect_attribute, foreign_dialect, root.where});
    }
    scene_.files.push_back(file);
    scene_.texts.push_back(std::move(text));
    chain_.push_back(fs::canonical(file, none).string());
    splice(root, depth);
    chain_.pop_back();
    return true;
  }

 private:
  /// At most what the limits leave is read: a huge file or many small ones cost a sentence, not memory.
  bool readText(const std::string& file, const SourceLocation& where, std::string& text) {
    std::error_code none;
    // what is included can be a pipe, which would be waited for; the scene itself may come from one
    const bool is_waited_for = !chain_.empty() && !fs::is_regular_file(file, none);
    std::ifstream in;
    if (!is_waited_for) in.open(file, std::ios::binary);
    if (is_waited_for || !in || fs::is_directory(file, none))
      return diagnostics_.error(where, {}, "the file " + file + " cannot be read"), false;
    std::vector<char> chunk(1 << 16);
    while (in && text.size() <= limits_.file_bytes) {
      in.read(chunk.data(), std::streamsize(chunk.size()));
      text.append(chunk.data(), std::size_t(in.gcount()));
    }
    constexpr std::size_t cost_of_a_file = 4096;
    const std::size_t cost = std::max(text.size(), cost_of_a_file);
    if (!chain_.empty() && cost > bytes_left_)
      return diagnostics_.error(
                 where, {},
                 "the scene and the files it includes are larger than " + std::to_string(limits_.file_bytes) + " bytes together"),
             false;
    bytes_left_ -= std::min(cost, bytes_left_);
    return true;
  }

  bool reportCircle(const std::string& canonical, const SourceLocation& where) {
    std::string circle;
    for (auto file = std::find(chain_.begin(), chain_.end(), canonical); file != chain_.end(); ++file) circle += *file + " -> ";
    diagnostics_.error(where, {}, "a file includes itself: " + circle + canonical);
    return false;
  }

  void splice(NodeDescription& node, int depth) {
    if (depth > limits_.depth) {
      diagnostics_.error(node.where, {}, "with its includes the scene is nested more than " + std::to_string(limits_.depth) + " deep");
      node.children.clear();
      return;
    }
    for (NodeDescription& child : node.children) splice(child, depth + 1);
    std::vector<ComponentDescription> written;
    written.swap(node.components);
    for (ComponentDescription& component : written) {
      if (component.type == "include") {
        include(component, depth, node);
      } else if (const std::string prefab = prefabOf(component); !prefab.empty()) {
        spliceFile(prefab, component.where, component, depth, node, true);
      } else {
        node.components.push_back(std::move(component));
      }
    }
  }

  void include(const ComponentDescription& element, int depth, NodeDescription& into) {
    const AttributeDescription* href = element.find("href");
    if (!href || href->value.empty()) return diagnostics_.error(element.where, {}, "<include> does not name a file", "href=\"...\"");
    std::vector<std::string> searched;
    const std::string file = findFileIn(href->value, element.folder, scene_.data_paths, &searched);
    if (file.empty())
      return diagnostics_.error(href->where, {}, "the included file " + inQuotes(href->value) + " is not found", {},
                                searchedText(searched));
    spliceFile(file, href->where, element, depth, into);
  }

  /// The file that stands for an element of an unknown type, or empty.
  std::string prefabOf(const ComponentDescription& element) const {
    const bool is_known = !is_known_ || is_known_(element.type);
    if (is_known && !(is_foreign_ && isPrefabAbroad(element.type))) return {};
    return findFileIn("Objects/" + element.type + ".xml", element.folder, scene_.data_paths, nullptr);
  }

  void spliceFile(const std::string& file, const SourceLocation& where, const ComponentDescription& element, int depth,
                  NodeDescription& into, bool is_prefab = false) {
    NodeDescription root;
    if (!read(file, where, depth + 1, root, is_prefab)) return;
    const std::string kind = root.name();
    for (const AttributeDescription& attribute : element.attributes)
      if (attribute.name != "href") replace(attribute, root);
    if (kind == "Group" || kind == "_Group_") {
      move(root, into);
    } else if (kind == "_Merge_") {
      merge(root, into);
    } else {
      into.children.push_back(std::move(root));
    }
  }

  // ---- attributes of <include> ----

  /// `attribute` replaces those of the same name in all included elements; `name__attribute` in the elements of that
  /// name; `name` is the name of the included node.
  void replace(const AttributeDescription& attribute, NodeDescription& root) {
    if (attribute.name == "name") return setAttribute(root.attributes, attribute);
    std::string only, name = attribute.name;
    if (const auto split = name.find("__"); split != std::string::npos && split > 0)
      only = name.substr(0, split), name = name.substr(split + 2);
    std::vector<std::string> known;
    if (replaceIn(root, only, name, attribute, known) > 0) return;
    diagnostics_.add({is_foreign_ ? Severity::warning : Severity::error,
                      attribute.where,
                      {},
                      "no included element" + (only.empty() ? "" : " named " + inQuotes(only)) + " has an attribute " + inQuotes(name) +
                          (is_foreign_ ? ": it is dropped" : ""),
                      "an attribute that the included file writes",
                      nearest(name, known)});
  }

  static int replaceIn(NodeDescription& node, const std::string& only, const std::string& name, const AttributeDescription& by,
                       std::vector<std::string>& known) {
    int count = 0;
    const auto apply = [&](auto& element) {
      if (!only.empty() && element.name() != only) return;
      for (AttributeDescription& attribute : element.attributes) {
        if (known.size() < 1000) known.push_back(attribute.name);
        if (attribute.name == name) attribute.value = by.value, attribute.where = by.where, ++count;
      }
    };
    apply(node);
    for (ComponentDescription& component : node.components) apply(component);
    for (NodeDescription& child : node.children) count += replaceIn(child, only, name, by, known);
    return count;
  }

  static void setAttribute(std::vector<AttributeDescription>& attributes, const AttributeDescription& by) {
    for (AttributeDescription& attribute : attributes)
      if (attribute.name == by.name) return void(attribute = by);
    attributes.push_back(by);
  }

  // ---- what becomes of the included root ----

  static void move(NodeDescription& from, NodeDescription& into) {
    std::move(from.components.begin(), from.components.end(), std::back_inserter(into.components));
    std::move(from.children.begin(), from.children.end(), std::back_inserter(into.children));
  }

  /// Elements of equal type and name become one; the included attributes win.
  static void merge(NodeDescription& from, NodeDescription& into) {
    for (ComponentDescription& component : from.components) {
      const auto same = std::find_if(into.components.begin(), into.components.end(),
                                     [&](const auto& other) { return other.type == component.type && other.name() == component.name(); });
      if (same == into.components.end()) {
        into.components.push_back(std::move(component));
      } else {
        for (const AttributeDescription& attribute : component.attributes) setAttribute(same->attributes, attribute);
      }
    }
    for (NodeDescription& child : from.children) {
      const auto same =
          std::find_if(into.children.begin(), into.children.end(), [&](const auto& other) { return other.name() == child.name(); });
      if (same == into.children.end()) {
        into.children.push_back(std::move(child));
      } else {
        for (const AttributeDescription& attribute : child.attributes) setAttribute(same->attributes, attribute);
        merge(child, *same);
      }
    }
  }

  const ReadLimits& limits_;
  const KnownType& is_known_;
  const std::vector<Override>& overrides_;
  SceneDescription& scene_;
  Diagnostics& diagnostics_;
  std::size_t bytes_left_;
  bool is_foreign_ = false;         ///< the scene is in the dialect of another program
  std::vector<std::string> chain_;  ///< files being read, outermost first
};

/// <AddResourceRepository path="..."/> extends the search for files, wherever it stands.
void collectRepositories(const NodeDescription& node, std::vector<std::string>& out) {
  for (const ComponentDescription& component : node.components) {
    const AttributeDescription* path = component.find("path");
    if (component.type == "AddResourceRepository" && path)
      out.push_back((fs::path(component.folder) / path->value).lexically_normal().string());
  }
  for (const NodeDescription& child : node.children) collectRepositories(child, out);
}

}  // namespace

SceneDescription readScene(const std::string& file, const std::vector<Override>& overrides, const ReadLimits& limits,
                           Diagnostics& diagnostics) {
  return readSceneWithPrefabs(file, overrides, limits, {}, diagnostics);
}

SceneDescription readSceneWithPrefabs(const std::string& file, const std::vector<Override>& overrides, const ReadLimits& limits,
                                      const KnownType& is_known, Diagnostics& diagnostics, const std::string* text) {
  SceneDescription scene;
  scene.file = file;
  scene.data_paths = environmentDataPaths();
  if (!text && !fs::exists(file)) {
    diagnostics.error({file, 0, 0}, {}, "the scene file is not found");
    return scene;
  }
  Resolver resolver(limits, is_known, overrides, scene, diagnostics);
  if (!(text ? resolver.take({file, *text, false}, 1, scene.root) : resolver.read(file, {file, 1, 1}, 1, scene.root))) {
    scene.root = {};
    return scene;
  }
  std::vector<std::string> repositories;
  collectRepositories(scene.root, repositories);
  scene.data_paths.insert(scene.data_paths.begin(), repositories.begin(), repositories.end());
  applyOverrides(overrides, scene.root, diagnostics);
  return scene;
}

}  // namespace stroma
