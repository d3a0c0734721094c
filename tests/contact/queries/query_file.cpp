// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tests/contact/queries/query_file.h"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <ostream>
#include <stdexcept>
#include <string_view>

#include "components/contact/longest_step.h"
#include "framework/collision/exact_intersection.h"
#include "tests/contact/exact_pairs.h"

namespace stroma::test {

using namespace exact_pairs;
namespace files = std::filesystem;

namespace {

constexpr std::size_t lines_of_query = 8, numbers_of_point = 6;

[[noreturn]] void refuse(const std::string& file, long line, const std::string& what) {
  throw std::runtime_error(fmt::format("{}:{}: {}", file, line, what));
}

std::vector<std::string_view> wordsOf(std::string_view line) {
  std::vector<std::string_view> words;
  while (!line.empty() && (line.back() == '\r' || line.back() == ' ')) line.remove_suffix(1);
  for (std::size_t from = 0; from <= line.size();) {
    const std::size_t to = std::min(line.find(',', from), line.size());
    words.push_back(line.substr(from, to - from));
    from = to + 1;
  }
  return words;
}

/// Whole numbers that doubles hold make a quotient that is rounded once; others are divided as they are.
double quotient(std::string_view above, std::string_view below, bool& is_rounded) {
  constexpr long long most = 1LL << 53;
  const auto whole = [](std::string_view text, long long& value) {
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && end == text.data() + text.size() && std::abs(value) <= most;
  };
  long long a = 0, b = 0;
  if (whole(above, a) && whole(below, b) && b != 0) {
    const double value = double(a) / double(b);
    is_rounded = is_rounded || std::fma(value, double(b), -double(a)) != 0;
    return value;
  }
  const Rational exact_value{boost::multiprecision::cpp_int(std::string(above)),
                             boost::multiprecision::cpp_int(std::string(below))};
  const double value = exact_value.convert_to<double>();
  is_rounded = is_rounded || Rational(value) != exact_value;
  return value;
}

void readPoint(const std::vector<std::string_view>& words, Vec3& point, bool& is_rounded) {
  for (int k = 0; k < 3; ++k) point[k] = quotient(words[std::size_t(2 * k)], words[std::size_t(2 * k + 1)], is_rounded);
}

std::string truthBeside(const std::string& file) {
  const files::path path(file), folder = path.parent_path();
  for (const files::path& found :
       {folder / "mma_bool" / (path.stem().string() + "_mma_bool.json"),
        folder.parent_path() / "mma_bool" / (path.stem().string() + "_mma_bool.json"), folder / "mma_bool.json"})
    if (files::exists(found)) return found.string();
  return {};
}

void readTruth(const std::string& file, std::vector<Query>& queries) {
  std::ifstream in(file);
  const nlohmann::json truth = nlohmann::json::parse(in, nullptr, false);
  if (!truth.is_array() || truth.size() != queries.size())
    throw std::runtime_error(fmt::format("{}: expected an array of {} booleans, one for each query", file, queries.size()));
  for (std::size_t i = 0; i < queries.size(); ++i) {
    if (!truth[i].is_boolean() && !truth[i].is_number_integer())
      throw std::runtime_error(fmt::format("{}: entry {} is neither true nor false", file, i));
    queries[i].meets = truth[i].is_boolean() ? truth[i].get<bool>() : truth[i].get<int>() != 0;
  }
}

}  // namespace

std::vector<Query> readQueries(const std::string& file, const std::string& truth) {
  std::ifstream in(file);
  if (!in) throw std::runtime_error(file + ": no such file");
  std::vector<Query> queries;
  std::size_t at = 0;
  bool has_truth = true;
  long number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    const std::vector<std::string_view> words = wordsOf(line);
    if (line.empty() || line[0] == '#' || (words.size() == 1 && words[0].empty())) continue;
    if (words.size() != numbers_of_point && words.size() != numbers_of_point + 1)
      refuse(file, number,
             fmt::format("{} numbers; expected three numerators and denominators and the truth, 0 or 1", words.size()));
    if (at == 0) queries.emplace_back();
    Query& query = queries.back();
    try {
      readPoint(words, (at < 4 ? query.start : query.end)[at % 4], query.is_rounded);
    } catch (const std::exception&) {
      refuse(file, number, "a coordinate is no rational number; expected whole numbers, and no denominator of zero");
    }
    if (words.size() == numbers_of_point) {
      has_truth = false;
    } else {
      if (words.back() != "0" && words.back() != "1")
        refuse(file, number, fmt::format("the truth is {}; expected 0 or 1", words.back()));
      const bool meets = words.back() == "1";
      if (at > 0 && meets != query.meets)
        refuse(file, number, "the truth is another one than in the lines before of the same query");
      query.meets = meets;
    }
    at = (at + 1) % lines_of_query;
  }
  if (at != 0) refuse(file, number, fmt::format("ends within a query; expected {} lines for each", lines_of_query));
  const std::string beside = truth.empty() && !has_truth ? truthBeside(file) : truth;
  if (!beside.empty())
    readTruth(beside, queries);
  else if (!has_truth)
    refuse(file, number, "lines without truth; expected a seventh number, --truth FILE, or mma_bool.json beside the file");
  return queries;
}

PairKind kindOfQueries(const std::string& file) {
  const std::string stem = files::path(file).stem().string(), path = files::absolute(file).string();
  const auto last = [&path](const char* word) { return path.rfind(word); };
  const std::size_t faces = last("vertex-face"), edges = last("edge-edge");
  if (faces != std::string::npos && (edges == std::string::npos || faces > edges)) return PairKind::point_triangle;
  if (edges != std::string::npos) return PairKind::edge_edge;
  if (stem.ends_with("vf")) return PairKind::point_triangle;
  if (stem.ends_with("ee")) return PairKind::edge_edge;
  throw std::runtime_error(file + ": of which kind? Expected vertex-face or edge-edge in the path, or --kind");
}

void QueryCounts::add(const QueryCounts& o) {
  if (cut + o.cut > 0) way_left = (way_left * double(cut) + o.way_left * double(o.cut)) / double(cut + o.cut);
  queries += o.queries, meeting += o.meeting, rounded += o.rounded;
  missed += o.missed, cut += o.cut, at_once += o.at_once;
  seconds += o.seconds, checked += o.checked, touching += o.touching, wrong_certificates += o.wrong_certificates;
  distance_error = std::max(distance_error, o.distance_error);
}

namespace {

/// By the test that BarrierContact makes after each step.
bool meetExactly(PairKind kind, const FourPoints& x) {
  return kind == PairKind::edge_edge ? segmentMeetsTriangle(x[0], x[1], x[2], x[3], x[3])
                                     : segmentMeetsTriangle(x[0], x[0], x[1], x[2], x[3]);
}

void check(PairKind kind, const Query& query, double t, QueryCounts& counts) {
  ++counts.checked;
  FourPoints stop;
  std::array<Exact, 4> exact_stop;
  double size = 0;
  for (std::size_t i = 0; i < 4; ++i) {
    stop[i] = query.start[i] + t * (query.end[i] - query.start[i]);
    const Exact from = exact(query.start[i]);
    exact_stop[i] = from + Rational(t) * (exact(query.end[i]) - from);
    size = std::max(size, (query.start[i] - query.start[0]).norm());
  }
  if (t > 0 && squaredDistance(kind, exact_stop) == 0) ++counts.touching;
  for (const FourPoints& x : {query.start, query.end, stop})
    counts.wrong_certificates += meetExactly(kind, x) != (squaredDistance(kind, exact(x)) == 0);
  const double distance = std::sqrt(squaredDistance(kind, exact(query.start)).convert_to<double>());
  if (size > 0)
    counts.distance_error =
        std::max(counts.distance_error, std::abs(closestPoints(kind, query.start).distance() - distance) / size);
}

}  // namespace

QueryCounts answer(PairKind kind, const std::vector<Query>& queries, const QueryOptions& options) {
  QueryCounts counts;
  counts.queries = long(queries.size());
  std::vector<double> ways(queries.size());
  const std::clock_t begin = std::clock();
  for (std::size_t q = 0; q < queries.size(); ++q) {
    FourPoints dx;
    for (std::size_t i = 0; i < 4; ++i) dx[i] = queries[q].end[i] - queries[q].start[i];
    ways[q] = longestStep(kind, queries[q].start, dx, {.left = options.left});
  }
  counts.seconds = double(std::clock() - begin) / CLOCKS_PER_SEC;
  double left = 0;
  for (std::size_t q = 0; q < queries.size(); ++q) {
    const bool is_free = ways[q] == 1;
    counts.rounded += queries[q].is_rounded;
    counts.meeting += queries[q].meets;
    counts.missed += queries[q].meets && is_free;
    if (!queries[q].meets && !is_free) ++counts.cut, counts.at_once += ways[q] == 0, left += ways[q];
    if (long(q) < options.exact) check(kind, queries[q], ways[q], counts);
  }
  if (counts.cut > 0) counts.way_left = left / double(counts.cut);
  return counts;
}

}  // namespace stroma::test
