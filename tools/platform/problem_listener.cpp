// SPDX-License-Identifier: LGPL-2.1-or-later
#include "framework/scene/problem_listener.h"

#include <cstdio>

namespace stroma {

void (*problem_listener)(const Problem&) = [](const Problem& problem) { std::fprintf(stderr, "%s\n", problem.text().c_str()); };

}  // namespace stroma
