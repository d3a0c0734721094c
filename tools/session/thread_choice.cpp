// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/session/thread_choice.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <stdexcept>

#include "framework/algebra/parallel.h"
#include "tools/session/processors.h"

namespace stroma {
namespace {

enum class Source { nobody, size, user };
std::atomic<Source> source{Source::nobody};

/// Systems step one after the other: the largest one says how much work there is at once.
Index nodesAtOnce(const Simulation& simulation) {
  Index most = 0;
  for (const auto& system : simulation.systems()) most = std::max(most, system->independentRows());
  return most;
}

int threadsFor(Index nodes) {
  return nodes < 2 * nodes_per_thread ? 1 : threadsThatPay(nodes, usableCores());  // small scenes do not look at the machine
}

}  // namespace

int threadsThatPay(Index nodes, int most) { return int(std::clamp<Index>(nodes / nodes_per_thread, 1, most)); }

void giveThreads(int count) {
  source = Source::user;
  setThreads(count);
}

bool chooseThreads(bool on) {
  if (const char* text = std::getenv("STROMA_THREADS"); text && *text && source == Source::nobody) {
    char* end = nullptr;
    const long count = std::strtol(text, &end, 10);
    if (*end != '\0' || count < 1 || count > 1024)
      throw std::invalid_argument(fmt::format("the environment variable STROMA_THREADS is '{}': expected 1 to 1024", text));
    giveThreads(int(count));
  }
  const Source before = source;
  if (before == Source::user) return false;
  source = on ? Source::size : Source::nobody;
  if (!on) setThreads(1);
  return before == Source::size;
}

void takeThreadsFor(const Simulation& simulation) {
  if (source == Source::size) setThreads(threadsFor(nodesAtOnce(simulation)));
}

std::string threadsText(const Simulation& simulation) {
  if (source != Source::size) return fmt::format("{}", threads());
  const Index nodes = nodesAtOnce(simulation);
  const int count = threadsFor(nodes);
  const char* const of = simulation.systems().size() > 1 ? "the largest system has" : "the system has";
  if (nodes < 2 * nodes_per_thread)
    return fmt::format("1, because {} {} independent nodes; a second thread pays from {} on", of, nodes, 2 * nodes_per_thread);
  return fmt::format("{} of {} usable cores; {} {} independent nodes, and one thread pays per {}", count, usableCores(), of, nodes,
                     nodes_per_thread);
}

}  // namespace stroma
