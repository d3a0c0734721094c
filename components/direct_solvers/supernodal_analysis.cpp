// SPDX-License-Identifier: LGPL-2.1-or-later
#include "components/direct_solvers/supernodal_analysis.h"

#include <SuiteSparse_config.h>
#include <omp.h>

#include <algorithm>
#include <bit>
#include <new>
#include <stdexcept>
#include <utility>

#include "components/direct_solvers/left_work.h"
#include "framework/algebra/memory.h"
#include "framework/algebra/ordering_lock.h"

namespace stroma {
namespace {

/// Patterns of fewer nodes are analysed in a tenth of a second.
constexpr Index few_rows = 4000;

/// Memory for CHOLMOD: a factor is written once and read a few times, so that small pages, each a fault, cost as much
/// as the factorisation (16^3 hexahedra: 140 MB, a third of the run).
void* allocateForCholmod(std::size_t bytes) {
  try {
    return allocateArray(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}

/// Another pattern gives another number, as good as always. An order fits any pattern of as many nodes.
std::uint64_t mixedPattern(const BlockMatrix& matrix) {
  std::uint64_t mixed = 1;
  for (const std::vector<Index>* numbers : {&matrix.rowStart(), &matrix.columns()})
    for (const Index number : *numbers) mixed = (std::rotl(mixed, 29) ^ std::uint64_t(number)) * 0x9e3779b97f4a7c15u;
  return mixed;
}

}  // namespace

NoRegions::NoRegions() : before_(omp_get_max_active_levels()) { omp_set_max_active_levels(0); }

NoRegions::~NoRegions() { omp_set_max_active_levels(before_); }

SupernodalAnalysis::SupernodalAnalysis() {
  [[maybe_unused]] static const bool once = [] {
    SuiteSparse_config.malloc_func = allocateForCholmod;
    return true;
  }();
  cholmod_start(&common);
  common.supernodal = CHOLMOD_SUPERNODAL;
  common.nmethods = 1;
  common.print = 0;
  common.quick_return_if_not_posdef = 1;
}

SupernodalAnalysis::~SupernodalAnalysis() {
  cholmod_free_sparse(&lower, &common);
  cholmod_free_factor(&factor, &common);
  cholmod_finish(&common);
}

void SupernodalAnalysis::check(bool good, const char* what) const {
  if (good && common.status >= 0) return;
  const char* cause = common.status == CHOLMOD_OUT_OF_MEMORY ? ": out of memory"
                      : common.status == CHOLMOD_TOO_LARGE ? ": the factor has more entries than a 32-bit index counts"
                                                           : "";
  throw std::runtime_error(std::string("SparseLDLSolver could not ") + what + cause);
}

std::shared_ptr<SupernodalAnalysis> SupernodalAnalysis::of(const BlockMatrix& matrix, StopToken stop,
                                                           const SupernodalAnalysis* former) {
  const auto analysis = std::make_shared<SupernodalAnalysis>();
  analysis->pattern = mixedPattern(matrix);
  if (former && former->pattern == analysis->pattern && former->unknown.size() == 3 * std::size_t(matrix.rows()))
    analysis->unknown = former->unknown, analysis->ordering = former->ordering;
  const auto graph = std::make_shared<const Graph>(Graph{matrix.rowStart(), matrix.columns(), matrix.diagonal()});
  if (matrix.rows() < few_rows || !stop.isWatched())
    analysis->run(*graph);
  else if (!runOrLeave([analysis, graph] { analysis->run(*graph); }, reinterpret_cast<const void*>(&allocateForCholmod), stop))
    return nullptr;
  analysis->graph_ = graph;
  return analysis;
}

void SupernodalAnalysis::run(const Graph& graph) {
  const NoRegions no_regions;
  if (unknown.empty()) unknown = orderUnknowns(graph);
  buildLower(graph);
  common.method[0].ordering = CHOLMOD_NATURAL;
  common.postorder = 0;
  factor = cholmod_analyze(lower, &common);
  check(factor, "analyse the matrix");
  flops = common.fl, entries = common.lnz;
}

SupernodalPattern SupernodalAnalysis::supernodes() const {
  return {int(factor->n),
          int(factor->nsuper),
          static_cast<const int*>(factor->super),
          static_cast<const int*>(factor->pi),
          static_cast<const int*>(factor->px),
          static_cast<const int*>(factor->s)};
}

Index SupernodalAnalysis::Graph::slot(Index row, Index column) const {
  const auto begin = columns.begin() + row_start[row], end = columns.begin() + row_start[row + 1];
  return Index(std::lower_bound(begin, end, column) - columns.begin());
}

/// The permuted lower triangle: its column k holds unknown[k], and the source of each value is noted. The unknowns of a node follow
/// each other, so the neighbours of a node are sorted once for its three columns.
void SupernodalAnalysis::buildLower(const Graph& graph) {
  const Index nodes = graph.rows();
  std::vector<Index> place_of(graph.diagonal.size());
  for (Index k = 0; k < nodes; ++k) place_of[std::size_t(unknown[std::size_t(3 * k)] / 3)] = k;
  std::vector<int> start(1, 0), rows;
  const std::size_t most = 9 * ((graph.columns.size() - std::size_t(nodes)) / 2 + std::size_t(nodes));
  start.reserve(unknown.size() + 1), rows.reserve(most), source.reserve(most);
  struct Neighbour {
    Index place, slot;
    bool is_transposed;  ///< the slot is that of the block on the other side of the diagonal
  };
  std::vector<Neighbour> below;
  for (Index k = 0; k < nodes; ++k) {
    const Index node = unknown[std::size_t(3 * k)] / 3;
    below.clear();
    for (Index s = graph.row_start[node]; s < graph.row_start[node + 1]; ++s) {
      const Index other = graph.columns[s], place = place_of[std::size_t(other)];
      // a value is read from the upper triangle, whichever side of the permuted diagonal it lies on
      if (place >= k) below.push_back({place, other >= node ? s : graph.slot(other, node), other < node});
    }
    std::sort(below.begin(), below.end(), [](const Neighbour& a, const Neighbour& b) { return a.place < b.place; });
    for (int component = 0; component < 3; ++component) {
      for (const Neighbour& at : below)
        for (int c = at.place == k ? component : 0; c < 3; ++c) {
          rows.push_back(3 * at.place + c);
          source.push_back(9 * at.slot + (at.is_transposed ? 3 * c + component : 3 * component + c));
        }
      start.push_back(int(rows.size()));
    }
  }
  lower = cholmod_allocate_sparse(unknown.size(), unknown.size(), rows.size(), 1, 1, -1, CHOLMOD_REAL, &common);
  check(lower, "allocate the matrix");
  std::copy(start.begin(), start.end(), static_cast<int*>(lower->p));
  std::copy(rows.begin(), rows.end(), static_cast<int*>(lower->i));
}

/// The upper triangle of the nodes' graph.
cholmod_sparse* SupernodalAnalysis::upper(const Graph& graph) {
  const std::size_t nodes = std::size_t(graph.rows());
  cholmod_sparse* triangle =
      cholmod_allocate_sparse(nodes, nodes, graph.columns.size(), 1, 1, -1, CHOLMOD_PATTERN, &common);
  check(triangle, "allocate the graph");
  int count = 0;
  int* start = static_cast<int*>(triangle->p);
  for (std::size_t i = 0; i < nodes; ++i) {
    start[i] = count;
    for (Index s = graph.diagonal[i]; s < graph.row_start[i + 1]; ++s)
      static_cast<int*>(triangle->i)[count++] = graph.columns[s];
  }
  start[nodes] = count;
  return triangle;
}

/// Whether a better order than that of minimum degree may save what METIS takes: 0.7 us for each entry of the nodes' graph, for a
/// fifth to two thirds of the operations in large bodies, and none in slender ones. Of the flops of both orders of 28 bodies of 996 to
/// 17,576 nodes: about ten factorisations repay it on this line.
bool SupernodalAnalysis::isDissectionWorth(const Graph& nodes, double block_flops) {
  constexpr double flops_of_block = 27, worth_for_entry = 20e3;
  return flops_of_block * block_flops > worth_for_entry * double(nodes.columns.size());
}

/// The order of the unknowns that costs the fewest flops, postordered. Orders are compared on the graph of the nodes: a node's
/// three unknowns have one pattern. Minimum degree takes a tenth of what METIS does.
std::vector<int> SupernodalAnalysis::orderUnknowns(const Graph& nodes) {
  std::vector<int> node_order(std::size_t(nodes.rows())), best;
  cholmod_sparse* graph = upper(nodes);
  common.method[0].ordering = CHOLMOD_GIVEN;
  common.supernodal = CHOLMOD_SIMPLICIAL;
  common.postorder = 1;
  double fewest = 0;
  const auto metis = [&] {
    const std::lock_guard lock(orderingLock());
    return cholmod_metis(graph, nullptr, 0, 1, node_order.data(), &common);
  };
  for (const char* method : {"AMD", "METIS"}) {
    const bool is_metis = *method == 'M';
    if (is_metis && !best.empty() && !isDissectionWorth(nodes, fewest)) break;
    const bool good = is_metis ? metis() : cholmod_amd(graph, nullptr, 0, node_order.data(), &common);
    if (!good) continue;
    cholmod_factor* trial = cholmod_analyze_p(graph, node_order.data(), nullptr, 0, &common);
    if (trial && (best.empty() || common.fl < fewest)) {
      const int* permutation = static_cast<int*>(trial->Perm);
      best.assign(permutation, permutation + node_order.size());
      fewest = common.fl;
      ordering = method;
    }
    cholmod_free_factor(&trial, &common);
  }
  common.supernodal = CHOLMOD_SUPERNODAL;
  cholmod_free_sparse(&graph, &common);
  check(!best.empty(), "order the matrix");
  std::vector<int> order(best.size() * 3);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = 3 * best[k / 3] + int(k % 3);
  return order;
}

}  // namespace stroma
