// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshOBJLoader on any bytes.
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  stroma::fuzz::loadMesh("MeshOBJLoader", ".obj", {reinterpret_cast<const char*>(data), size},
                         "onlyAttachedPoints=\"true\"");
  return 0;
}
