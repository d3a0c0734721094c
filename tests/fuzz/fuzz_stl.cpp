// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshSTLLoader on any bytes, text and binary.
#include "tests/fuzz/fuzz.h"

STROMA_FUZZ_TARGET(stl) {
  stroma::fuzz::loadMesh("MeshSTLLoader", ".stl", {reinterpret_cast<const char*>(data), size}, "flipNormals=\"true\"");
  return 0;
}
