// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>
#include <vector>

#include "tools/bench/figure.h"

namespace stroma::bench {

/// One limit of the machine as measured: rates of several repetitions in `unit`, the best of them the limit.
struct MachineFigure {
  std::string name, unit;
  std::vector<double> rates;
};

struct Machine {
  std::string processor, level;  ///< model name; instruction set whose loops ran
  int lanes = 0;
  double cache_bytes = 0;  ///< level 2
  Limits limits;
  std::vector<MachineFigure> figures;
};

/// About two seconds.
Machine measureMachine();

}  // namespace stroma::bench
