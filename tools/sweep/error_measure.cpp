// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/sweep/error_measure.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

#include "framework/scene/diagnostics.h"
#include "framework/scene/text.h"
#include "tools/sweep/axis.h"

namespace stroma::sweep {
namespace {

constexpr std::string_view words[] = {"l2", "max", "energy"};

/// "(0.2 0 0.01)"
Vec3 placeIn(const std::string& text) {
  Words parts(std::string_view(text).substr(1, text.size() - 2));
  Vec3 place;
  for (int c = 0; c < 3; ++c)
    if (!readNumber(std::string(parts.next()), place[c]))
      throw std::invalid_argument(
          fmt::format("--error: {} is no place (expected (x y z) at rest, in m)", inQuotes(text)));
  if (!parts.next().empty())
    throw std::invalid_argument(fmt::format("--error: {} has more than three numbers", inQuotes(text)));
  return place;
}

double at(const nlohmann::json& summary, const char* part) {
  // numbers that are not finite are null there
  const nlohmann::json* place = &summary;
  for (const char* key : {"energies", "end", part}) {
    if (!place->is_object() || !place->contains(key)) return std::nan("");
    place = &(*place)[key];
  }
  return place->is_number() ? place->get<double>() : std::nan("");
}

Vec3 atPlace(const ErrorMeasure& measure, const EndState& end) {
  std::vector<std::string> paths;
  for (const Body& body : end.bodies) {
    paths.push_back(body.path);
    if (body.path != measure.state) continue;
    if (body.cells() == 0) throw std::runtime_error(fmt::format("{} has no volume cells around a place", body.path));
    const Place found = CellFinder(body).find(measure.place);
    if (measure.name == "velocity") return found.of(body.v);
    return measure.name == "position" ? found.of(body.x) : Vec3(found.of(body.x) - found.of(body.rest));
  }
  throw std::runtime_error(
      fmt::format("there is no state {} (expected one of: {})", measure.state, fmt::join(paths, ", ")));
}

}  // namespace

Values vectorsOf(const std::vector<double>& numbers) {
  Values values((numbers.size() + 2) / 3, Vec3::Zero());
  for (std::size_t i = 0; i < numbers.size(); ++i)
    values[i / 3][Index(i % 3)] = (numbers.size() == 6 && i >= 3 ? std::numbers::sqrt2 : 1) * numbers[i];
  return values;
}

ErrorMeasure ErrorMeasure::parse(const std::string& text) {
  ErrorMeasure measure;
  measure.text = text;
  for (std::size_t i = 0; i < std::size(words); ++i)
    if (text == words[i]) {
      measure.kind = Kind(i);
      return measure;
    }
  const auto colon = text.find(':'), dot = text.rfind('.', colon);
  if (!text.starts_with('/') || dot == std::string::npos) {
    const std::string near = nearest(text, {words, words + std::size(words)});
    throw std::invalid_argument(fmt::format(
        "--error {}: expected l2, max, energy or PATH.NAME[:NODES], as /beam/dofs.displacement:@/beam/end.indices{}",
        text, near.empty() ? "" : fmt::format("; did you mean {}?", near)));
  }
  measure.kind = Kind::quantity, measure.quantity = text;
  if (colon == std::string::npos || !text.substr(colon + 1).starts_with('(') || !text.ends_with(')')) return measure;
  measure.kind = Kind::place;
  measure.state = text.substr(0, dot), measure.name = text.substr(dot + 1, colon - dot - 1);
  const std::vector<std::string> names{"displacement", "position", "velocity"};
  if (std::ranges::find(names, measure.name) == names.end())
    throw std::invalid_argument(fmt::format(
        "--error {}: a place has a displacement, a position and a velocity, and no {}", text, measure.name));
  measure.place = sweep::placeIn(text.substr(colon + 1));
  return measure;
}

std::string ErrorMeasure::title() const {
  switch (kind) {
    case Kind::l2:
      return "error of the displacements (L2)";
    case Kind::max:
      return "largest error of the displacements";
    case Kind::energy:
      return "error of the energy";
    case Kind::place:
      return fmt::format("error of {}.{} at ({:g} {:g} {:g})", state, name, place[0], place[1], place[2]);
    case Kind::quantity:
      break;
  }
  return "error of " + quantity;
}

Values ErrorMeasure::valuesOf(const EndState& end, const nlohmann::json& summary, const CommonPoints& points) const {
  Values values;
  if (isField())
    values = points.displacements(end);
  else if (kind == Kind::energy)
    values = {Vec3(at(summary, "kinetic") + at(summary, "elastic"), 0, 0)};
  else if (kind == Kind::place)
    values = {atPlace(*this, end)};
  else if (end.quantity.empty())
    throw std::runtime_error(fmt::format("the run does not tell {}", quantity));
  else
    values = vectorsOf(end.quantity);
  for (const Vec3& value : values)
    if (!value.allFinite()) throw std::runtime_error("the end of the run is not finite");
  return values;
}

double ErrorMeasure::norm(const Values& values, const CommonPoints& points) const {
  double sum = 0, most = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    sum += (isField() ? points.weights()[i] : 1) * values[i].squaredNorm();
    most = std::max(most, values[i].norm());
  }
  return kind == Kind::max ? most : std::sqrt(sum);
}

double ErrorMeasure::cosine(const Values& a, const Values& b, const CommonPoints& points) const {
  double ab = 0, aa = 0, bb = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    const double weight = isField() ? points.weights()[i] : 1;
    ab += weight * a[i].dot(b[i]), aa += weight * a[i].squaredNorm(), bb += weight * b[i].squaredNorm();
  }
  return aa > 0 && bb > 0 ? ab / std::sqrt(aa * bb) : 0;
}

double ErrorMeasure::distance(const Values& a, const Values& b, const CommonPoints& points) const {
  if (a.size() != b.size())
    throw std::runtime_error(fmt::format("{} has {} numbers, what it is compared with {}", isField() ? "the run" : quantity,
                                         3 * a.size(), 3 * b.size()));
  Values difference(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) difference[i] = a[i] - b[i];
  return norm(difference, points);
}

}  // namespace stroma::sweep
