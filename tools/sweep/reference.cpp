// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/reference.h"

#include <fmt/format.h>
#include <muParser.h>

#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <stdexcept>

#include "framework/scene/text.h"
#include "framework/simulation/state_file.h"
#include "tools/sweep/axis.h"

namespace stroma::sweep {
namespace {

/// Up to three formulas with a semicolon between them.
class Formula final : public GivenReference {
 public:
  Formula(const std::string& text, bool is_field) : text_(text), is_field_(is_field) {
    std::size_t from = 0, count = 0;
    for (; from <= text.size(); ++count) {
      const std::size_t end = std::min(text.find(';', from), text.size());
      if (count < 3) read(count, text.substr(from, end - from));
      from = end + 1;
    }
    if (is_field ? count != 3 : count != 1 && count != 3)
      throw std::invalid_argument(fmt::format("--reference {} has {} formulas (expected {})", inQuotes(text), count,
                                              is_field ? "three, \"ux; uy; uz\"" : "one or three"));
    used_ = count;
  }
  Values valuesAt(const CommonPoints& points, double t) const override {
    t_ = t;
    if (!is_field_) return {at(Vec3::Zero())};
    Values values;
    for (const Vec3& place : points.places()) values.push_back(at(place));
    return values;
  }
  bool dependsOnTime() const override { return true; }
  std::string text() const override { return "the formula " + text_; }

 private:
  Vec3 at(const Vec3& place) const {
    place_ = place;
    Vec3 value = Vec3::Zero();
    for (std::size_t c = 0; c < used_; ++c) value[Index(c)] = parsers_[c].Eval();
    if (!value.allFinite())
      throw std::runtime_error(fmt::format("--reference {} is not finite at ({:g} {:g} {:g})", inQuotes(text_),
                                           place[0], place[1], place[2]));
    return value;
  }
  void read(std::size_t c, const std::string& text) {
    try {
      mu::Parser& parser = parsers_[c];
      constexpr std::array names{"x", "y", "z"};
      for (std::size_t i = 0; i < 3 && is_field_; ++i) parser.DefineVar(names[i], &place_[Index(i)]);
      parser.DefineVar("t", &t_);
      parser.DefineConst("pi", std::numbers::pi);
      parser.SetExpr(text);
      parser.Eval();
    } catch (const mu::Parser::exception_type& problem) {
      throw std::invalid_argument(
          fmt::format("--reference {} is neither finest nor extrapolated, no file, and no formula: {}", inQuotes(text_),
                      problem.GetMsg()));
    }
  }

  std::string text_;
  bool is_field_;
  std::size_t used_ = 0;
  mutable Vec3 place_ = Vec3::Zero();
  mutable double t_ = 0;
  std::array<mu::Parser, 3> parsers_;
};

/// Points with displacements, or a quantity, from a file.
class GivenValues final : public GivenReference {
 public:
  GivenValues(std::string text, std::vector<Vec3> places, Values values)
      : text_(std::move(text)),
        points_(places.empty() ? CommonPoints() : CommonPoints(std::move(places))),
        values_(std::move(values)) {}
  CommonPoints points() const override { return points_; }
  Values valuesAt(const CommonPoints&, double) const override { return values_; }
  std::string text() const override { return "the file " + text_; }

 private:
  std::string text_;
  CommonPoints points_;
  Values values_;
};

/// A run that was measured before.
class GivenEnd final : public GivenReference {
 public:
  GivenEnd(std::string text, const ErrorMeasure& measure)
      : text_(std::move(text)), measure_(measure), end_(EndState::read(text_)) {
    if (measure_.kind == ErrorMeasure::Kind::energy)
      throw std::invalid_argument("--reference " + text_ + ": the file tells no energy (expected a formula)");
    if (measure_.isField()) points_ = CommonPoints(end_);
  }
  CommonPoints points() const override { return points_; }
  Values valuesAt(const CommonPoints& points, double) const override { return measure_.valuesOf(end_, {}, points); }
  std::optional<double> time() const override { return end_.time; }
  std::string text() const override { return "the run that left " + text_; }

 private:
  std::string text_;
  ErrorMeasure measure_;
  EndState end_;
  CommonPoints points_;
};

std::vector<std::vector<double>> rowsIn(const std::string& file) {
  std::ifstream stream(file);
  std::vector<std::vector<double>> rows;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    ++number;
    const std::string_view text = trimmed(line);
    if (text.empty() || text.front() == '#') continue;
    std::vector<double> row;
    Words words(text);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) {
      double value = 0;
      if (!readNumber(std::string(word), value)) break;
      row.push_back(value);
    }
    if (row.empty() && rows.empty()) continue;  // a line of names
    if (row.size() != 1 && row.size() != 3 && row.size() != 6)
      throw std::invalid_argument(
          fmt::format("--reference {}:{}: {} numbers (expected x y z ux uy uz)", file, number, row.size()));
    rows.push_back(row);
  }
  return rows;
}

std::unique_ptr<GivenReference> fromTable(const std::string& file, const ErrorMeasure& measure) {
  const auto rows = rowsIn(file);
  const std::size_t wanted = measure.isField() ? 6 : 0;
  if (rows.empty() || (wanted == 0 && rows.size() != 1))
    throw std::invalid_argument(
        fmt::format("--reference {}: expected {}", file,
                    wanted ? "lines \"x y z ux uy uz\"" : "one line with one, three or six numbers"));
  if (wanted == 0) return std::make_unique<GivenValues>(file, std::vector<Vec3>(), vectorsOf(rows[0]));
  std::vector<Vec3> places;
  Values values;
  for (const std::vector<double>& row : rows) {
    if (row.size() != wanted)
      throw std::invalid_argument(
          fmt::format("--reference {}: a line has {} numbers (expected x y z ux uy uz)", file, row.size()));
    places.emplace_back(row.data());
    values.emplace_back(row.data() + 3);
  }
  return std::make_unique<GivenValues>(file, std::move(places), std::move(values));
}

std::unique_ptr<GivenReference> fromRecording(const std::string& file, const ErrorMeasure& measure) {
  if (!measure.isField())
    throw std::invalid_argument(fmt::format("--reference {}: a recording is for --error l2 or max", file));
  const std::vector<StateFrame> frames = readStateFile(file);
  if (frames.empty() || frames.front().x.size() != frames.back().x.size())
    throw std::invalid_argument(
        fmt::format("--reference {}: expected a recording with a first and a last instant", file));
  const std::vector<Vec3>& rest = frames.front().x0.empty() ? frames.front().x : frames.front().x0;
  Values values = frames.back().x;
  for (std::size_t i = 0; i < values.size(); ++i) values[i] -= rest[i];
  return std::make_unique<GivenValues>(file, rest, std::move(values));
}

}  // namespace

std::unique_ptr<GivenReference> parseReference(const std::string& text, const ErrorMeasure& measure) {
  if (text == "finest" || text == "extrapolated") return nullptr;
  if (std::filesystem::is_regular_file(text)) {
    if (text.ends_with(".state") || text.ends_with(".state.gz")) return fromRecording(text, measure);
    if (text.ends_with(".csv") || text.ends_with(".txt")) return fromTable(text, measure);
    return std::make_unique<GivenEnd>(text, measure);
  }
  return std::make_unique<Formula>(text, measure.isField());
}

}  // namespace stroma::sweep
