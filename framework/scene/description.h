// SPDX-License-Identifier: LGPL-2.1-or-later
// A scene as written: plain data, before any component exists.
#pragma once
#include <memory>
#include <string>
#include <vector>

#include "framework/scene/diagnostics.h"

namespace stroma {

class Data;

struct AttributeDescription {
  std::string name;
  std::string value;
  SourceLocation where;
  /// Location of the value in the file that an override replaces; no line if the file has none.
  SourceLocation overridden{};
  /// The value itself, if a program passed one without converting it to text; the text above is then empty.
  std::shared_ptr<const Data> typed{};
};

/// `<Type name="..." attribute="value"/>`.
struct ComponentDescription {
  std::string type;
  std::vector<AttributeDescription> attributes;
  SourceLocation where;
  std::string folder;  ///< folder of the file that contains the element: the base of relative file names

  const AttributeDescription* find(std::string_view attribute) const;
  std::string name() const;  ///< the attribute `name`, or empty
};

/// `<Node name="...">`: attributes, components and children, each in the order of the file.
struct NodeDescription {
  std::vector<AttributeDescription> attributes;
  std::vector<ComponentDescription> components;
  std::vector<NodeDescription> children;
  SourceLocation where;
  std::string folder;

  const AttributeDescription* find(std::string_view attribute) const;
  std::string name() const;
};

/// A file of a scene as read.
struct SceneFileText {
  std::string file, text;
  bool is_on_disk = true;  ///< read from disk, not passed by a program
  bool is_prefab = false;  ///< the file of a prefab element
};

struct SceneDescription {
  NodeDescription root;
  std::string file;
  std::vector<std::string> files;       ///< the scene and everything it included
  std::vector<SceneFileText> texts;     ///< of `files`; none when the scene was not read from a text
  std::vector<std::string> data_paths;  ///< folders searched for files after the element's own
};

}  // namespace stroma
