// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/topology/gmsh_elements.h"

namespace stroma {

namespace {

struct Known {
  int number, nodes;
  std::string_view name;
};

constexpr Known without_kind[] = {{8, 3, "quadratic edges"}};

constexpr Known quadratic[] = {{10, 9, "quads"}, {12, 27, "hexahedra"}, {13, 18, "prisms"}, {14, 14, "pyramids"},
                               {16, 8, "quads"}, {17, 20, "hexahedra"}, {18, 15, "prisms"}, {19, 13, "pyramids"}};

}  // namespace

GmshElement gmshElement(int number, const GmshCursor& where) {
  if (const CellKind* kind = kindByNumber(&CellKind::gmsh, number)) return {kind, kind->nodes, kind->plural};
  for (const Known& known : without_kind)
    if (known.number == number) return {nullptr, known.nodes, known.name};
  for (const Known& known : quadratic)
    if (known.number == number)
      where.fail(fmt::format("quadratic {} ({} nodes) are not supported", known.name, known.nodes),
                 "linear elements (Mesh.ElementOrder = 1 in Gmsh), or quadratic tetrahedra and triangles");
  where.fail(fmt::format("elements of type {} are not known", number),
             "Gmsh's linear elements, quadratic tetrahedra and triangles");
}

}  // namespace stroma
