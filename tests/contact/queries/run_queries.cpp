// SPDX-License-Identifier: LGPL-2.1-or-later
#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <ostream>
#include <stdexcept>

#include "tests/contact/queries/query_file.h"

namespace stroma::test {

namespace files = std::filesystem;

namespace {

constexpr const char* help =
    "usage: contact_queries [OPTION]... FILE|FOLDER...\n"
    "\n"
    "Asks BarrierContact's filter for the longest step of each query of a published set of continuous collision\n"
    "detection, and compares with the truth that the set gives. A query is eight lines, one for each point: those of\n"
    "a vertex and a triangle or of two edges where they start, and the same where they end,\n"
    "  x numerator, x denominator, y numerator, y denominator, z numerator, z denominator, truth (1: they meet)\n"
    "Of folders all .csv files are taken whose path has vertex-face or edge-edge, or whose name ends in vf or ee.\n"
    "\n"
    "  --kind KIND    vertex-face or edge-edge, whatever the path says\n"
    "  --truth FILE   a JSON array of booleans for lines without truth; mma_bool.json beside the file is found\n"
    "  --left PART    part of the first distance that ends a step (0.1, as in BarrierContact)\n"
    "  --exact N      queries of each file that are checked in rational numbers besides (1000)\n"
    "\n"
    "The exit code is 0 where nothing is missed, 1 where something is missed or an exact test is wrong, and 2 for bad input.\n"
    "\n"
    "  contact_queries Sample-Queries\n"
    "  contact_queries --kind edge-edge --exact 0 data_0_0.csv\n";

struct Request {
  std::vector<std::string> files;
  std::optional<PairKind> kind;
  std::string truth;
  QueryOptions options;
  bool wants_help = false;
};

double numberOf(const std::string& option, const std::string& text, double low, double high) {
  char* end = nullptr;
  const double value = std::strtod(text.c_str(), &end);
  if (text.empty() || *end != 0 || !(value >= low && value <= high))
    throw std::runtime_error(fmt::format("{} is \"{}\"; expected a number from {:g} to {:g}", option, text, low, high));
  return value;
}

PairKind kindOf(const std::string& word) {
  if (word == "vertex-face") return PairKind::point_triangle;
  if (word == "edge-edge") return PairKind::edge_edge;
  throw std::runtime_error(fmt::format("--kind is \"{}\"; expected vertex-face or edge-edge", word));
}

void addFiles(const std::string& path, std::vector<std::string>& found) {
  if (!files::is_directory(path)) return found.push_back(path);
  const std::size_t before = found.size();
  for (const auto& entry : files::recursive_directory_iterator(path))
    if (entry.path().extension() == ".csv") found.push_back(entry.path().string());
  if (found.size() == before) throw std::runtime_error(path + ": no .csv file in this folder");
  std::sort(found.begin() + std::ptrdiff_t(before), found.end());
}

Request readRequest(const std::vector<std::string>& arguments) {
  Request request;
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const std::string& word = arguments[i];
    if (word == "--help" || word == "-h") {
      request.wants_help = true;
    } else if (word == "--kind" || word == "--truth" || word == "--left" || word == "--exact") {
      if (++i == arguments.size()) throw std::runtime_error(word + " has no value");
      if (word == "--kind") request.kind = kindOf(arguments[i]);
      if (word == "--truth") request.truth = arguments[i];
      if (word == "--left") request.options.left = numberOf(word, arguments[i], 1e-9, 0.9);
      if (word == "--exact") request.options.exact = long(numberOf(word, arguments[i], 0, 1e9));
    } else if (word.starts_with("--")) {
      throw std::runtime_error(fmt::format("unknown option {}; --help lists them", word));
    } else {
      addFiles(word, request.files);
    }
  }
  if (request.files.empty() && !request.wants_help) throw std::runtime_error("no file; --help says what one looks like");
  return request;
}

void print(const std::string& name, const QueryCounts& counts, std::ostream& out) {
  out << fmt::format("{}: {} queries, {} meet: {} missed. {} of {} that are free are cut short", name, counts.queries,
                     counts.meeting, counts.missed, counts.cut, counts.queries - counts.meeting);
  if (counts.cut > 0)
    out << fmt::format(", {} of them to nothing, to {:.2g} of their way on average", counts.at_once, counts.way_left);
  out << fmt::format(". {:.3g} us each\n", 1e6 * counts.seconds / double(std::max(1L, counts.queries)));
  if (counts.rounded > 0) out << fmt::format("  {} have coordinates that are no doubles: these are rounded\n", counts.rounded);
  if (counts.checked > 0)
    out << fmt::format(
        "  {} in rational numbers: {} touch where they stop, {} answers of the exact test are wrong, first distances are off by "
        "{:.1g} of the pair\n",
        counts.checked, counts.touching, counts.wrong_certificates, counts.distance_error);
}

}  // namespace

int runQueries(const std::vector<std::string>& arguments, std::ostream& out, std::ostream& err) {
  try {
    const Request request = readRequest(arguments);
    if (request.wants_help) {
      out << help;
      return 0;
    }
    QueryCounts all;
    for (const std::string& file : request.files) {
      const PairKind kind = request.kind ? *request.kind : kindOfQueries(file);
      const QueryCounts counts = answer(kind, readQueries(file, request.truth), request.options);
      print(file, counts, out);
      all.add(counts);
    }
    if (request.files.size() > 1) print(fmt::format("all {} files", request.files.size()), all, out);
    return all.isGood() ? 0 : 1;
  } catch (const std::exception& error) {
    err << "contact_queries: " << error.what() << "\n";
    return 2;
  }
}

}  // namespace stroma::test
