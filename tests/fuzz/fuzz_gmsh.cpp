// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshGmshLoader on any bytes: formats 1 to 4.1, text and binary.
#include "tests/fuzz/fuzz.h"

STROMA_FUZZ_TARGET(gmsh) {
  stroma::fuzz::loadMesh("MeshGmshLoader", ".msh", {reinterpret_cast<const char*>(data), size}, "triangulate=\"true\"");
  return 0;
}
