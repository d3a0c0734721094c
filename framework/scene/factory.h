// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

/// The factory's entry of a component type.
struct ComponentEntry {
  std::string type;    ///< name in a scene
  std::string help;    ///< one line
  std::string module;  ///< set when a module registers it
  std::function<std::unique_ptr<Component>()> make;
};

/// Creates components by the name used in a scene. Filled by explicit calls: each module lists its components (CMake
/// generates the list), so nothing depends on the order of static initialisers.
class Factory {
 public:
  /// Registers `T` as `type`. `defaults`, if given, changes members before the table is declared: the same component
  /// under another name with its own defaults. A duplicate name is a programming error and throws std::logic_error.
  template <class T>
  void add(std::string type, std::string help, std::function<void(T&)> defaults = {}) {
    insert(
        {std::move(type), std::move(help), module_, [defaults = std::move(defaults)]() -> std::unique_ptr<Component> {
           auto component = std::make_unique<T>();
           if (defaults) defaults(*component);
           return component;
         }});
  }
  /// A new component with its attribute table declared and its name set to its type; null when the type is unknown.
  std::unique_ptr<Component> make(const std::string& type) const;
  const ComponentEntry* find(const std::string& type) const;
  std::vector<const ComponentEntry*> entries() const;  ///< sorted by type

  void setModule(std::string module) { module_ = std::move(module); }

 private:
  void insert(ComponentEntry entry);
  std::string module_;
  std::map<std::string, ComponentEntry> entries_;
};

}  // namespace stroma

/// In a component's .cpp: `STROMA_COMPONENT(file_stem) { factory.add<T>("Name", "one line"); }`, the stem of the .cpp's
/// own name. The build lists every stem of a module in its generated registry.
#define STROMA_COMPONENT(stem) extern "C" void stroma_register_##stem([[maybe_unused]] ::stroma::Factory& factory)
