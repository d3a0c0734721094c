// SPDX-License-Identifier: LGPL-2.1-or-later
// What the whole numbers of attributes count. An attribute that is not known here is refused where a mesh changes.
#pragma once
#include <algorithm>
#include <iterator>
#include <string>
#include <string_view>

#include "tools/session/mesh_edit.h"

namespace stroma {

/// Whether a list of names has the name.
template <std::size_t n>
bool isIn(const std::string& name, const std::string_view (&list)[n]) {
  return std::find(std::begin(list), std::end(list), name) != std::end(list);
}

/// The link of a component of this type whose state an attribute numbers; empty: that of its own node.
std::string linkOf(const std::string& type, const std::string& attribute);

/// Whether the whole number of an attribute is that of a node, of the state that linkOf() tells.
bool namesOneNode(const std::string& type, const std::string& attribute);
/// The same of the last of the states that a mapping maps from.
bool namesOneMapped(const std::string& type, const std::string& attribute);

/// What the whole numbers of an attribute count.
enum class ListKind { nodes, edges, triangles, quads, quadratic_triangles, tetrahedra, hexahedra, nothing, unknown };
/// By the name of the attribute, which has one meaning in all components.
ListKind kindOf(std::string attribute);
/// Null: those of nothing, or of what is not known.
const ListOrigins* originsOf(const MeshEdit& edit, ListKind kind);

}  // namespace stroma
