// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/command/long_work.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <memory>

#include "framework/simulation/long_work.h"
#include "tools/session/told_line.h"

namespace stroma::command {
namespace {

constexpr double few_operations = 1e11;  // a few seconds
std::atomic<int> telling{0};

}  // namespace

bool isTellingLongWork() { return telling > 0; }

namespace {

class ToldWork final : public LongWorkListener {
 public:
  explicit ToldWork(std::string what) : what_(std::move(what)) { ++telling; }
  ~ToldWork() override { --telling; }
  void advise(const std::string& sentence) override { fmt::print(stderr, "{}: {}\n", what_, sentence); }
  void say(double share) override;

 private:
  std::string what_;
  ToldLine line_;
  int last_ = -1;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

void ToldWork::say(double share) {
  share = std::min(share, 1.0);
  const int step = int(share * (line_.isOnTerminal() ? 100 : 4));
  if (step <= last_) return;
  last_ = step;
  const bool ends = share >= 0.999;
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  // the first share says little of the rest
  const std::string to_go = ends || share < 0.02 ? "" : durationText(seconds * (1 - share) / share) + " to go";
  const std::string tail = fmt::format(": {:.0f} %{}{}", 100 * share, to_go.empty() ? "" : ", ", to_go);
  line_.tell(fittedLine(what_, tail, line_.width()));
  if (!ends || !line_.isOnTerminal()) return;
  fmt::print(stderr, "\n");
  line_.leave();
}

}  // namespace

void tellLongWork(bool wanted) {
  if (!wanted) return listenToLongWork({});
  listenToLongWork([](const std::string& what, double operations) {
    return operations < few_operations ? nullptr : std::make_unique<ToldWork>(what);
  });
}

}  // namespace stroma::command
