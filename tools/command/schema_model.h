// SPDX-License-Identifier: LGPL-2.1-or-later
// What a scene may hold, read from the attribute tables of all components: elements, their attributes, and the help that an
// editor shows. Everything is sorted by name, so that the same components give the same text.
#pragma once
#include <string>
#include <vector>

#include "tools/command/schema_value.h"
#include "tools/session/session.h"

namespace stroma::command {

/// One attribute under all the names that a scene may write it by.
struct SchemaAttribute {
  std::vector<std::string> names;  ///< the present one first; at most one of them is written
  SchemaValue value;
  std::string help;
  bool required = false;
  bool by_src = false;  ///< `src` can give it too
};

/// The attributes of a component, of a Node, or of an element that may have any others too.
struct SchemaType {
  enum class Kind { component, node, anything };
  std::string name;
  Kind kind = Kind::component;
  std::vector<SchemaAttribute> attributes{};  ///< of a component: besides the shared ones
};

/// An element inside a Node, by the name of its type. Several elements share one when a component was renamed.
struct SchemaElement {
  std::string name, type, help;
};

struct Schema {
  std::string version;                  ///< of the command
  std::vector<SchemaAttribute> shared;  ///< what every component takes, `src` among them
  std::vector<SchemaType> types;
  std::vector<SchemaElement> elements;
  SchemaType node;
  std::string node_help;
  std::vector<std::string> roots;  ///< what the outermost element may be called; all hold what a Node holds
  std::size_t components = 0, modules = 0;
};

/// Opens all modules.
Schema makeSchema(Session& session);

}  // namespace stroma::command
