// SPDX-License-Identifier: LGPL-2.1-or-later
// MeshSTLLoader on any bytes, text and binary.
#include "tests/fuzz/fuzz.h"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  stroma::fuzz::loadMesh("MeshSTLLoader", ".stl", {reinterpret_cast<const char*>(data), size}, "flipNormals=\"true\"");
  return 0;
}
