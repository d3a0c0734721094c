// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshOBJLoader on any bytes.
#include "tests/fuzz/fuzz.h"

STROMA_FUZZ_TARGET(obj) {
  stroma::fuzz::loadMesh("MeshOBJLoader", ".obj", {reinterpret_cast<const char*>(data), size},
                         "onlyAttachedPoints=\"true\"");
  return 0;
}
