// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <string>

#include "tools/bench/figure.h"
#include "tools/bench/machine.h"

namespace stroma::bench {

/// Collects repetitions into the catalogue and shows each figure as it comes.
class Collector final : public benchmark::BenchmarkReporter {
 public:
  explicit Collector(Catalogue& catalogue) : catalogue_(catalogue) {}
  bool ReportContext(const Context&) override { return true; }
  void ReportRuns(const std::vector<Run>& runs) override;

 private:
  Catalogue& catalogue_;
};

void printMachine(const Machine& machine);
/// Every figure that was measured: median, least, share of the limit, target, others.
void printTable(const Catalogue& catalogue, const Machine& machine);
/// The same and every repetition. Throws OutputError when the file cannot be written.
void writeJson(const std::string& file, const Catalogue& catalogue, const Machine& machine);

}  // namespace stroma::bench
