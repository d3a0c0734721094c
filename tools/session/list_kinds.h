// SPDX-License-Identifier: LGPL-2.1-or-later
// What the integers of attributes index. An attribute that is not listed here is an error when a mesh changes.
#pragma once
#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "tools/session/mesh_edit.h"

namespace stroma {

/// Whether a list of names contains the name.
template <std::size_t n>
bool isIn(const std::string& name, const std::string_view (&list)[n]) {
  return std::find(std::begin(list), std::end(list), name) != std::end(list);
}

/// The link of this component type to the state that an attribute indexes; empty: the state of its own node.
std::string linkOf(const std::string& type, const std::string& attribute);

/// Whether the integer of an attribute is a node of the state given by linkOf().
bool namesOneNode(const std::string& type, const std::string& attribute);
/// The same for the last of the parent states of a mapping.
bool namesOneMapped(const std::string& type, const std::string& attribute);

/// What the integers of an attribute index.
enum class ListKind { nodes, edges, triangles, quads, quadratic_triangles, tetrahedra, hexahedra, nothing, unknown };
/// By the name of the attribute, which means the same in all components.
ListKind kindOf(std::string attribute);
/// Null: nothing, or unknown.
const ListOrigins* originsOf(const MeshEdit& edit, ListKind kind);

}  // namespace stroma
