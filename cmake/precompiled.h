// SPDX-License-Identifier: LGPL-2.1-or-later
// Headers of other libraries that most files include: the compiler reads them once for each set of flags. Files include
// what they use all the same, and compile without this one.
//
// The compiler knows these files again by their content, comments too: see cmake/cached.sh.
#pragma once
#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <variant>
#include <vector>
