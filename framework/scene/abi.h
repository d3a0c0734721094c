// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include "framework/scene/headers_digest.h"  // made by framework/CMakeLists.txt

/// Identifies everything that a module and the framework must share: version, compiler, definitions that change layouts,
/// and every header of the framework.
#define STROMA_ABI "stroma-" STROMA_VERSION "-gcc" STROMA_STRINGIFY(__GNUC__) "-eigen64-" STROMA_HEADERS_DIGEST
#define STROMA_STRINGIFY_(x) #x
#define STROMA_STRINGIFY(x) STROMA_STRINGIFY_(x)
