// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/load.h"

#include <algorithm>

#include "framework/scene/change_table.h"
#include "framework/scene/dialect.h"
#include "framework/scene/files.h"
#include "framework/scene/instantiation.h"
#include "framework/scene/prefab.h"
#include "framework/scene/spans.h"

namespace stroma {

Scene instantiate(SceneDescription description, Factory& factory, Modules& modules, Diagnostics diagnostics) {
  const Span span("make components");
  Scene scene;
  scene.description = std::move(description);
  scene.diagnostics = std::move(diagnostics);
  if (scene.description.data_paths.empty()) scene.description.data_paths = environmentDataPaths();
  rewriteForeign(scene.description, factory, modules, scene.diagnostics, scene.no_effect);
  Instantiation(scene, factory, modules).run();
  if (scene.diagnostics.hasErrors()) throw SceneError(std::move(scene.diagnostics));
  return scene;
}

KnownType knownTypes(const Factory& factory, const Modules& modules) {
  return [&factory, &modules](const std::string& type) {
    return std::ranges::binary_search(modules.index(), std::string_view(type), {}, &Modules::IndexEntry::type) ||
           presentType(type) != type || std::ranges::count(typeRemovals(), type, &TypeRemoval::type) > 0 ||
           std::ranges::count(acceptedWithoutEffect(), type) > 0 || factory.find(type);
  };
}

namespace {

Scene loadFrom(const std::string& file, const std::string* text, const std::vector<Override>& overrides,
               Factory& factory, Modules& modules, const ReadLimits& limits) {
  Diagnostics diagnostics;
  SceneDescription description = [&] {
    const Span span("read the scene");
    return readSceneWithPrefabs(file, overrides, limits, knownTypes(factory, modules), diagnostics, text);
  }();
  // Without a tree there is nothing more to find; with one, an unreadable include does not hide the other problems.
  if (description.root.where.file.empty()) throw SceneError(std::move(diagnostics));
  return instantiate(std::move(description), factory, modules, std::move(diagnostics));
}

}  // namespace

Scene loadScene(const std::string& file, const std::vector<Override>& overrides, Factory& factory, Modules& modules,
                const ReadLimits& limits) {
  return loadFrom(file, nullptr, overrides, factory, modules, limits);
}

Scene loadSceneText(const std::string& xml, const std::string& name, const std::vector<Override>& overrides,
                    Factory& factory, Modules& modules, const ReadLimits& limits) {
  return loadFrom(name, &xml, overrides, factory, modules, limits);
}

Component* findComponent(Node& root, std::string_view path) {
  if (path.starts_with("/")) path.remove_prefix(1);
  const auto search = [&root](std::string_view rest) -> Component* {
    Node* node = &root;
    for (auto slash = rest.find('/'); slash != std::string_view::npos; slash = rest.find('/')) {
      node = node->findChild(rest.substr(0, slash));
      if (!node) return nullptr;
      rest.remove_prefix(slash + 1);
    }
    return node->findByName(rest);
  };
  if (Component* found = search(path)) return found;
  const std::string prefix = root.name() + "/";
  return path.starts_with(prefix) ? search(path.substr(prefix.size())) : nullptr;
}

}  // namespace stroma
